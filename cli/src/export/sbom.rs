//! The bill of materials of the runtime library (CycloneDX): what it is made of, as the lock file and the compiler say.

use super::archive::File;
use super::licenses::Linked;
use camdrive::drives::Fault;
use camdrive::drives::resource::BUILD;
use serde::Deserialize;
use serde_json::{Value, json};

/// The place inside the FMU; the standard asks for a reverse domain name.
pub const PATH: &str = "extra/org.camdrive.sbom/camdrive.cdx.json";

#[derive(Deserialize)]
struct Lock {
    package: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
    checksum: Option<String>,
    #[serde(default)]
    dependencies: Vec<String>,
}

impl Package {
    /// Its name as everyone's registers know it.
    fn reference(&self) -> String {
        format!("pkg:cargo/{}@{}", self.name, self.version)
    }
}

/// The bill of materials as a file of the FMU. What is no package is of the version of the compiler or the linker.
pub fn file(listed: &Linked) -> Result<File, Fault> {
    let lock: Lock =
        toml::from_str(include_str!("../../../Cargo.lock")).map_err(|e| Fault::new(format!("Cargo.lock: {e}")))?;
    // A dependency is `name`, with its version where there are several.
    let find = |dependency: &str| {
        let mut words = dependency.split(' ');
        let (name, version) = (words.next(), words.next());
        lock.package.iter().find(|p| Some(p.name.as_str()) == name && version.is_none_or(|v| p.version == v))
    };
    let linked = |package: &Package| -> Vec<&Package> {
        let found = package.dependencies.iter().filter_map(|dependency| find(dependency));
        found.filter(|p| listed.packages.contains(&p.name)).collect()
    };
    let mut packages: Vec<&Package> = find("camdrive").into_iter().collect();
    let mut next = 0;
    while let Some(package) = packages.get(next) {
        for more in linked(package) {
            if !packages.iter().any(|p| p.reference() == more.reference()) {
                packages.push(more);
            }
        }
        next += 1;
    }
    let reference = |(name, _): &(String, String)| format!("linked:{name}");
    let others = |list: &[(String, String)]| -> Vec<Value> {
        let component = |other: &(String, String)| {
            json!({ "type": "library", "bom-ref": reference(other), "name": other.0,
                "licenses": [{ "expression": other.1 }] })
        };
        list.iter().map(component).collect()
    };
    let mut dependencies: Vec<Value> = packages
        .iter()
        .map(|p| {
            let references = linked(p).into_iter().map(Package::reference);
            json!({ "ref": p.reference(), "dependsOn": references.chain(["rust-std".to_owned()]).collect::<Vec<_>>() })
        })
        .collect();
    let [inside, beside] = [&listed.in_standard_library, &listed.by_linker].map(|list| list.iter().map(reference));
    dependencies.push(json!({ "ref": "rust-std", "dependsOn": inside.chain(beside).collect::<Vec<_>>() }));
    let component = |p: &&Package| {
        let expression = if p.checksum.is_none() { "MIT OR Apache-2.0" } else { "Apache-2.0" };
        let mut component = json!({
            "type": "library", "bom-ref": p.reference(), "name": p.name, "version": p.version, "purl": p.reference(),
            "licenses": [{ "expression": expression }],
        });
        if let Some(checksum) = &p.checksum {
            component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
        }
        component
    };
    let mut own = packages.first().map(component).unwrap_or_default();
    own["properties"] = json!([{ "name": "camdrive:sources", "value": BUILD }]);
    let mut components: Vec<Value> = packages.iter().skip(1).map(component).collect();
    components.push(json!({
        "type": "library", "bom-ref": "rust-std", "name": "rust-std", "version": env!("CAMDRIVE_RUSTC"),
        "licenses": [{ "expression": "(MIT OR Apache-2.0) AND Unicode-3.0" }],
        "components": others(&listed.in_standard_library),
    }));
    components.extend(others(&listed.by_linker));
    let bill = json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": { "component": own }, "components": components, "dependencies": dependencies,
    });
    Ok(File::new(PATH, format!("{bill:#}\n")))
}

#[cfg(test)]
mod tests {
    use super::super::licenses;
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_bill_lists_every_linked_package_once_with_its_checksum() {
        let linked = licenses::linked().unwrap();
        let bill: Value = serde_json::from_slice(&file(&linked).unwrap().content).unwrap();
        assert_eq!(bill["metadata"]["component"]["name"], "camdrive");
        let components = bill["components"].as_array().unwrap();
        let packages: Vec<&Value> = components.iter().filter(|c| c["purl"].is_string()).collect();
        let names: BTreeSet<&str> = packages.iter().map(|c| c["name"].as_str().unwrap()).collect();
        assert_eq!(
            (names, packages.len()),
            (linked.packages.iter().map(String::as_str).collect(), linked.packages.len())
        );
        assert!(packages.iter().all(|c| c["hashes"][0]["content"].as_str().unwrap().len() == 64));
        assert_eq!(components.len(), packages.len() + 1 + linked.by_linker.len());
        // Beside every package: camdrive itself and the standard library.
        assert_eq!(bill["dependencies"].as_array().unwrap().len(), packages.len() + 2);
    }
}
