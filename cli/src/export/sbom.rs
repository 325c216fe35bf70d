//! The bills of materials of the runtime library and of the module of pages (CycloneDX), which `packaging/licenses.py` writes from
//! the lock file and the lists of linked packages; version, sources and compiler are from this build.

use super::archive::File;
use camdrive::drives::resource::BUILD;

/// The path inside the FMU; the standard requires a reverse domain name.
pub const PATH: &str = "extra/org.camdrive.sbom/camdrive.cdx.json";

/// The bill of materials of the library as a file of the FMU.
pub fn file() -> File {
    filled(PATH, include_str!("../../../packaging/camdrive.cdx.json"))
}

/// That of the module of pages.
pub fn of_page() -> File {
    filled("extra/org.camdrive.sbom/page.cdx.json", include_str!("../../../packaging/page.cdx.json"))
}

fn filled(path: &str, bill: &str) -> File {
    let bill = bill.replace("{version}", env!("CARGO_PKG_VERSION")).replace("{sources}", BUILD);
    File::new(path, bill.replace("{rust}", env!("CAMDRIVE_RUSTC")))
}

#[cfg(test)]
mod tests {
    use super::super::licenses;
    use super::*;
    use serde_json::Value;
    use std::collections::BTreeSet;

    #[test]
    fn the_bill_lists_every_linked_package_once_with_its_checksum() {
        let linked = licenses::linked().unwrap();
        let bill: Value = serde_json::from_slice(&file().content).unwrap();
        assert_eq!(bill["metadata"]["component"]["name"], "camdrive");
        let components = bill["components"].as_array().unwrap();
        let packages: Vec<&Value> = components.iter().filter(|c| c["purl"].is_string()).collect();
        let text = |of: &Value| of.as_str().unwrap().to_owned();
        let names: BTreeSet<String> = packages.iter().map(|c| text(&c["name"])).collect();
        assert_eq!((names, packages.len()), (linked.packages.iter().cloned().collect(), linked.packages.len()));
        let lock = include_str!("../../../Cargo.lock");
        for c in packages {
            let [name, version, sum] = [&c["name"], &c["version"], &c["hashes"][0]["content"]].map(text);
            let entry = format!("name = \"{name}\"\nversion = \"{version}\"\n");
            let (_, entry) = lock.split_once(&entry).expect("run packaging/licenses.py --bill");
            assert!(sum.len() == 64 && entry.lines().nth(1) == Some(&*format!("checksum = \"{sum}\"")), "{name}");
        }
        // Every package, the standard library, and the linker's additions.
        assert_eq!(components.len(), linked.packages.len() + 1 + linked.by_linker.len());
        assert_eq!(bill["dependencies"].as_array().unwrap().len(), linked.packages.len() + 2);
    }
}
