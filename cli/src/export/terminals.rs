//! terminalsAndIcons/: the drive's flange as one terminal, and an icon. Defined by FMI 3.0 (section 2.4.9), whose schema requires
//! `fmiVersion="3.0"`, and legal with FMI 2.0. Most importers ignore it, but FMI Library 3 treats that version as a fatal error in
//! an FMU of FMI 2.0, so it is written only on request.

use super::archive::File;
use super::picture;
use super::png::png;
use super::xml::Xml;
use camdrive::drives::variable::Causality;
use camdrive::drives::{AnyDrive, Description, Fault};
use camdrive_design::resource::Described;

/// The variables of a rotational flange apart from its torque.
const MOTION: [&str; 3] = ["phi", "w", "a"];

/// terminalsAndIcons.xml and the icon; empty for a unit without a flange.
pub fn files(drive: &Described) -> Result<Vec<File>, Fault> {
    let Some(flow) = flow(drive.descriptions()) else { return Ok(Vec::new()) };
    let icon = png(&picture::icon(&drive.curves()), 1.0)?;
    Ok(vec![
        File::new("terminalsAndIcons/terminalsAndIcons.xml", description(drive, flow)),
        File::new("terminalsAndIcons/icon.png", icon),
    ])
}

/// The direction of a positive `tau`: from the drive into a unit that is moved (`phi` is its input), out of a unit that moves
/// others (`tau` is its load). A unit that prescribes its own motion has no flange.
fn flow(descriptions: &[Description]) -> Option<&'static str> {
    let causality = |name: &str| descriptions.iter().find(|d| d.name == name).map(|d| d.causality);
    match (causality("phi")?, causality("tau")?) {
        (Causality::Input, Causality::Output) => Some("inflow"),
        (Causality::Output, Causality::Input) => Some("outflow"),
        _ => None,
    }
}

fn description(drive: &AnyDrive, flow: &str) -> String {
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
        let terminal = [
            ("name", "flange".to_owned()),
            ("matchingRule", "plug".to_owned()),
            ("description", "Shaft of the drive".to_owned()),
        ];
        let motion = MOTION.into_iter().filter(|name| exists(name)).map(|name| (name, name, "signal"));
        xml.element("Terminals", &[], |xml| {
            xml.element("Terminal", &terminal, |xml| {
                // With impacts, tau_mean is the torque to connect.
                let torque = if exists("tau_mean") { "tau_mean" } else { "tau" };
                for (variable, name, kind) in motion.chain([(torque, "tau", flow)]) {
                    let member = [("variableName", variable), ("memberName", name), ("variableKind", kind)];
                    xml.empty("TerminalMemberVariable", &member.map(|(key, value)| (key, value.to_owned())));
                }
            });
        });
    });
    xml.finish()
}
