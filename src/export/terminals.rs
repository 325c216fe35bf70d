//! terminalsAndIcons/: the drive's flange as one terminal, and an icon. Defined by FMI 3.0 (section 2.4.9) and
//! usable with FMI 2.0; importers that do not know it ignore the folder.

use super::archive::File;
use super::picture;
use super::xml::Xml;
use crate::drives::{DynDrive, Fault};

/// The variables of a rotational flange. The flow is positive into the unit, as in Modelica: a positive `tau`
/// is carried from the drive into the cam unit.
const FLANGE: [(&str, &str); 4] = [("phi", "signal"), ("w", "signal"), ("a", "signal"), ("tau", "inflow")];

/// terminalsAndIcons.xml and the icon.
pub fn files(drive: &dyn DynDrive) -> Result<Vec<File>, Fault> {
    let icon = picture::icon(&drive.curves()).png()?;
    Ok(vec![
        File::new("terminalsAndIcons/terminalsAndIcons.xml", description(drive)),
        File::new("terminalsAndIcons/icon.png", icon),
    ])
}

fn description(drive: &dyn DynDrive) -> String {
    let descriptions = drive.descriptions();
    let exists = |name: &str| descriptions.iter().any(|d| d.name == name);
    let mut xml = Xml::document();
    xml.element("fmiTerminalsAndIcons", &[("fmiVersion", "3.0".to_owned())], |xml| {
        xml.element("GraphicalRepresentation", &[], |xml| {
            let corners = || [("x1", "-100"), ("y1", "-100"), ("x2", "100"), ("y2", "100")];
            let mut system = corners().map(|(key, value)| (key, value.to_owned())).to_vec();
            system.push(("suggestedScalingFactorTo_mm", "0.1".to_owned()));
            xml.empty("CoordinateSystem", &system);
            xml.empty("Icon", &corners().map(|(key, value)| (key, value.to_owned())));
        });
        if exists("phi") && exists("tau") {
            let terminal = [
                ("name", "flange".to_owned()),
                ("matchingRule", "plug".to_owned()),
                ("description", "Shaft of the drive".to_owned()),
            ];
            xml.element("Terminals", &[], |xml| {
                xml.element("Terminal", &terminal, |xml| {
                    for (name, kind) in FLANGE.into_iter().filter(|(name, _)| exists(name)) {
                        let member = [("variableName", name), ("memberName", name), ("variableKind", kind)];
                        xml.empty("TerminalMemberVariable", &member.map(|(key, value)| (key, value.to_owned())));
                    }
                });
            });
        }
    });
    xml.finish()
}
