//! The bill of materials of the runtime library (CycloneDX): what it is made of, as the lock file and the compiler say.

use super::archive::File;
use super::licenses;
use camdrive::drives::Fault;
use camdrive::drives::resource::BUILD;
use serde::Deserialize;
use serde_json::{Value, json};

/// The place inside the FMU; the standard asks for a reverse domain name.
const PATH: &str = "extra/org.camdrive.sbom/camdrive.cdx.json";

/// What else is linked and under which licence, of the version of the compiler or the linker: what the standard library
/// contains, and what zig adds to the libraries that it links. third_party.txt has the notices.
const IN_STANDARD_LIBRARY: [(&str, &str); 14] = [
    ("addr2line", "Apache-2.0"),
    ("adler2", "Apache-2.0"),
    ("cfg-if", "Apache-2.0"),
    ("compiler_builtins", "Apache-2.0 WITH LLVM-exception AND MIT"),
    ("foldhash", "Zlib"),
    ("gimli", "Apache-2.0"),
    ("hashbrown", "Apache-2.0"),
    ("libc", "Apache-2.0"),
    ("libm", "MIT"),
    ("memchr", "MIT"),
    ("miniz_oxide", "Apache-2.0"),
    ("object", "Apache-2.0"),
    ("rustc-demangle", "Apache-2.0"),
    ("windows-targets", "Apache-2.0"),
];
const BY_LINKER: [(&str, &str); 4] = [
    ("compiler_rt", "MIT AND Apache-2.0 WITH LLVM-exception"),
    ("libunwind", "Apache-2.0 WITH LLVM-exception"),
    ("musl", "MIT"),
    ("mingw-w64", "ZPL-2.1"),
];

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

/// The bill of materials as a file of the FMU.
pub fn file() -> Result<File, Fault> {
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
        found.filter(|p| licenses::crates().any(|name| name == p.name)).collect()
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
    let reference = |(name, _): &(&str, &str)| format!("linked:{name}");
    let others = |list: &[(&str, &str)]| -> Vec<Value> {
        let component = |other: &(&str, &str)| {
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
    let [inside, beside] = [&IN_STANDARD_LIBRARY[..], &BY_LINKER].map(|list| list.iter().map(reference));
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
        "licenses": [{ "expression": "(MIT OR Apache-2.0) AND Unicode-3.0" }], "components": others(&IN_STANDARD_LIBRARY),
    }));
    components.extend(others(&BY_LINKER));
    let bill = json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": { "component": own }, "components": components, "dependencies": dependencies,
    });
    Ok(File::new(PATH, format!("{bill:#}\n")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_bill_lists_every_linked_package_once_with_its_checksum() {
        let bill: Value = serde_json::from_slice(&file().unwrap().content).unwrap();
        assert_eq!(bill["metadata"]["component"]["name"], "camdrive");
        let components = bill["components"].as_array().unwrap();
        let packages: Vec<&Value> = components.iter().filter(|c| c["purl"].is_string()).collect();
        let names: BTreeSet<&str> = packages.iter().map(|c| c["name"].as_str().unwrap()).collect();
        assert_eq!((names, packages.len()), (licenses::crates().collect(), licenses::crates().count()));
        assert!(packages.iter().all(|c| c["hashes"][0]["content"].as_str().unwrap().len() == 64));
        assert_eq!(components.len(), packages.len() + 1 + BY_LINKER.len());
        // Beside every package: camdrive itself and the standard library.
        assert_eq!(bill["dependencies"].as_array().unwrap().len(), packages.len() + 2);
    }

    #[test]
    fn what_else_is_linked_has_its_notice() {
        let notices = include_str!("third_party.txt");
        for (name, _) in IN_STANDARD_LIBRARY.iter().chain(&BY_LINKER) {
            assert!(notices.contains(name), "{name}");
        }
    }
}
