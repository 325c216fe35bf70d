//! Wrong scenes and what is said of them: `tests/scenes/x.toml` ↔ `tests/scenes/x.txt`; tasks in `tests/tasks`, studies in
//! `tests/studies`, systems in `tests/systems`.
//!
//! `BLESS=1 cargo test -p camdrive-cli --test suite scenes` writes the messages anew; look at the difference before keeping it.

use std::path::{Path, PathBuf};

/// The files of the folder with this extension, by name.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    // The names in the messages are relative to the folder of the workspace.
    std::env::set_current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()).expect("the folder is there");
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("a directory entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == extension));
    files.sort();
    files
}

/// The faults of a file.
type Read = fn(&Path) -> Option<String>;

/// Each folder with what reads its files.
const FOLDERS: [(&str, Read); 4] = [
    ("tests/scenes", |path| camdrive_cli::scene::read(path).err().map(|faults| faults.to_string())),
    ("tests/tasks", |path| camdrive_cli::task::read(path).err().map(|faults| faults.to_string())),
    ("tests/studies", |path| camdrive_cli::study::read(path).err().map(|faults| faults.to_string())),
    ("tests/systems", |path| camdrive_cli::system::read(path).err().map(|faults| faults.to_string())),
];

#[test]
fn wrong_scenes_and_tasks_get_the_stored_messages() {
    let bless = std::env::var_os("BLESS").is_some_and(|v| v == "1");
    let mut different = Vec::new();
    for (scene, read) in
        FOLDERS.iter().flat_map(|(folder, read)| files(folder, "toml").into_iter().map(move |f| (f, read)))
    {
        // The same path on every platform, since it is part of the message.
        let name = scene.to_string_lossy().replace('\\', "/");
        let faults = read(Path::new(&name)).unwrap_or_else(|| panic!("{name} should have faults"));
        let expected = scene.with_extension("txt");
        if bless {
            std::fs::write(&expected, &faults).expect("the message can be written");
        } else if std::fs::read_to_string(&expected).unwrap_or_default().replace("\r\n", "\n") != faults {
            different.push(format!("{name} says now:\n{faults}"));
        }
    }
    assert!(
        different.is_empty(),
        "{}\nrenew with BLESS=1 cargo test -p camdrive-cli --test suite scenes",
        different.join("\n")
    );
}

#[test]
fn references_and_schemas_are_those_of_the_declared_keys() {
    use camdrive_cli::document::input::Kind;
    use camdrive_cli::document::{reference, schema};
    let bless = std::env::var_os("BLESS").is_some_and(|v| v == "1");
    let page = |path: &Path| std::fs::read_to_string(path).expect("the page").replace("\r\n", "\n");
    let schema =
        |kind: Kind| (format!("docs/{}.schema.json", kind.word()).into(), format!("{:#}\n", schema::schema(kind)));
    let kinds = [Kind::Scene, Kind::Task, Kind::Study, Kind::System];
    let mut right: Vec<(PathBuf, String)> = kinds.map(schema).into();
    let mut pages = String::new();
    for path in files("docs", "md") {
        let text = page(&path);
        let name = path.display();
        let renewed = reference::renewed(&text).unwrap_or_else(|| panic!("{name} has a title of no table"));
        for (at, _) in text.match_indices("<!-- keys: ") {
            let since_the_last = text[..at].rsplit("<!-- end -->").next().unwrap_or_default();
            assert!(since_the_last.contains("\n##"), "{name}: no heading for {}", &text[at..at + 40]);
        }
        pages += &renewed;
        right.push((path, renewed));
    }
    for (path, right) in right {
        if bless {
            std::fs::write(&path, right).expect("the page can be written");
        } else {
            let name = path.display();
            assert!(
                page(&path) == right,
                "{name}: renew it with BLESS=1 cargo test -p camdrive-cli --test suite scenes"
            );
        }
    }
    for table in kinds.into_iter().flat_map(reference::tables) {
        assert!(pages.contains(&table.markdown()), "{} is in no reference", table.title);
    }
}

#[test]
fn every_stored_message_has_its_scene() {
    for message in FOLDERS.iter().flat_map(|(folder, _)| files(folder, "txt")) {
        assert!(message.with_extension("toml").exists(), "{} is left over", message.display());
    }
}

#[test]
fn derivatives_by_the_angle_may_have_their_unit_in_full() {
    let task = |of: [&str; 12]| {
        let [position, slope, bend, third, limit, weight, dwell, twist, first, second, wave, short] = of;
        let text = format!(
            "name = \"t\"\nharmonics = 5\nobjective = \"chebyshev\"\nddU_weight = {weight}\n\
             [[point]]\nphi = 1\nU = {position}\ndU = {slope}\nddU = {bend}\ndddU = {third}\n\
             [[bound]]\nof = \"ddU\"\nlimit = {limit}\n[[bound]]\nof = \"dddU\"\nmin = {twist}\n\
             [[dwell]]\nfrom = 2\nto = 3\nU = 0\ndU_tolerance = {dwell}\n\
             [[range]]\nfrom = 4\nto = 5\ndU = [{first}, {second}]\nddU = {wave}\nddU_tolerance = {short}\n"
        );
        let path = std::env::temp_dir().join(format!("camdrive_units_{}.toml", std::process::id()));
        std::fs::write(&path, text).expect("the folder can be written to");
        let read = camdrive_cli::task::read(&path);
        std::fs::remove_file(&path).expect("the file is there");
        read.unwrap_or_else(|faults| panic!("{faults}"))
    };
    let plain = task(["0.025", "0.025", "0.4", "0.003", "2", "0.1", "0.001", "-3", "0.5", "0.25", "0.125", "0.5"]);
    let lengths = task([
        "\"25 mm\"",
        "\"25 mm\"",
        "\"0.4 m\"",
        "\"3 mm\"",
        "\"2 m\"",
        "0.1",
        "\"1 mm\"",
        "\"-3 m\"",
        "\"50 cm\"",
        "\"25 cm\"",
        "\"125 mm\"",
        "\"0.5 m\"",
    ]);
    let full = task([
        "\"25 mm\"",
        "\"25 mm/rad\"",
        "\"400 mm/rad²\"",
        "\"3 mm/rad3\"",
        "\"2 m/rad^2\"",
        "\"0.1 rad2\"",
        "\"1 mm/rad\"",
        "\"-3 m/rad3\"",
        "\"500 mm/rad\"",
        "\"25 cm/rad2\"",
        "\"125 mm/rad2\"",
        "\"0.5 m/rad2\"",
    ]);
    assert_eq!(plain, lengths);
    assert_eq!(plain, full);
}
