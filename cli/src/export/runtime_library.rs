//! The runtime library of an FMU: where it comes from, and the checks before it is packed.

use super::hash::sha256;
use camdrive::drives::Fault;
use camdrive::drives::resource::BUILD;
use camdrive_design::text::reason;
use std::path::{Path, PathBuf};

/// The platforms of FMI 2.0 (section 2.3, with the further ones that 2.0.4 admits) and the suffix of their shared libraries.
pub const PLATFORMS: [(&str, &str); 8] = [
    ("linux64", ".so"),
    ("linux32", ".so"),
    ("aarch64-linux", ".so"),
    ("win64", ".dll"),
    ("win32", ".dll"),
    ("darwin64", ".dylib"),
    ("darwin32", ".dylib"),
    ("aarch64-darwin", ".dylib"),
];

/// A function that every importer needs; its name is in the library's table of exports.
const LANDMARK: &[u8] = b"fmi2DoStep";

/// A release build is smaller than two megabytes, a debug build has tens of them; this limit is between.
const LARGEST_RELEASE: usize = 4 << 20;

/// The command that builds the library.
const BUILD_COMMAND: &str = "cargo build --release --package camdrive-fmu";

/// A checked shared library.
#[derive(Clone, Debug)]
pub struct RuntimeLibrary {
    /// One of [`PLATFORMS`].
    pub platform: &'static str,
    /// The path of its file.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// The platforms whose libraries `packaging/build` makes.
pub const MADE: [&str; 4] = ["linux64", "aarch64-linux", "win64", "darwin64"];

impl RuntimeLibrary {
    /// The libraries of the `wanted` platforms or, if that is empty, all available ones: from `packaging/build`, in the folder
    /// `runtimes` next to the executable's folder (`target/release`) or in it, or at the place of a wheel, and the one built with
    /// the running executable. Also returns the reasons why others are left out.
    pub fn at_hand(wanted: &[String]) -> Result<(Vec<Self>, Vec<Fault>), Fault> {
        let (mut libraries, mut left_out) = (Vec::new(), Vec::new());
        for (platform, suffix) in PLATFORMS {
            let named = wanted.iter().any(|name| name == platform);
            // The library in darwin64 serves both processors; a second one is only packed if it is asked for.
            if !named && (!wanted.is_empty() || platform == "aarch64-darwin") {
                continue;
            }
            let file = format!("{}/camdrive{suffix}", platform.replace("aarch64-darwin", "darwin64"));
            let mut found = Err(missing(platform));
            if let Some(path) = &Self::places(&file)?.into_iter().find(|path| path.is_file()) {
                found = RuntimeLibrary::read(platform, path).inspect_err(|fault| left_out.push(fault.clone()));
            }
            if found.is_err() && host_platform() == Some(platform) {
                found = RuntimeLibrary::beside_executable();
            }
            match found {
                Ok(library) => libraries.push(library),
                Err(fault) if named => return Err(fault),
                Err(_) => (),
            }
        }
        if libraries.is_empty() {
            libraries.push(RuntimeLibrary::beside_executable()?);
        }
        Ok((libraries, left_out))
    }

    /// The places of a file in the folder `runtimes`.
    pub fn places(file: &str) -> Result<Vec<PathBuf>, Fault> {
        let executable = executable()?;
        // In a user's wheel on Windows the executable is a folder deeper.
        let places = [("", 1), ("", 2), ("share/camdrive", 2), ("share/camdrive", 3)].into_iter();
        let place = |(folder, above)| Some(executable.ancestors().nth(above)?.join(folder).join("runtimes").join(file));
        Ok(places.filter_map(place).collect())
    }

    /// The library built with the running executable, for the same platform: `cargo run` leaves it in the folder `deps` next to the
    /// executable, `cargo build` and packages put it next to the executable itself.
    pub fn beside_executable() -> Result<Self, Fault> {
        let platform = host_platform().ok_or_else(|| {
            Fault::new(format!("FMI 2.0 has no name for this platform; choose one with --runtime {}", choice()))
        })?;
        let executable = executable()?;
        let name = format!("{}camdrive_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let beside = executable.with_file_name(&name);
        let places = [executable.with_file_name("deps").join(&name), beside.clone()];
        // The newer one is from the last build.
        let built = |path: &PathBuf| std::fs::metadata(path).and_then(|file| file.modified()).ok();
        let found = places.into_iter().filter(|path| path.is_file()).max_by_key(built).ok_or_else(|| {
            Fault::new(format!(
                "the runtime library is missing: {} does not exist. Build it with `{BUILD_COMMAND}`, name one by --runtime \
                 {platform}=FILE, or run the `camdrive` that pip installed at its own path",
                beside.display()
            ))
        })?;
        RuntimeLibrary::read(platform, &found)
    }

    /// The library of `PLATFORM=FILE`.
    pub fn from_argument(argument: &str) -> Result<Self, Fault> {
        let is_whole =
            |(platform, file): &(&str, &str)| !file.is_empty() && PLATFORMS.iter().any(|(name, _)| name == platform);
        let (platform, file) = argument.split_once('=').filter(is_whole).ok_or_else(|| {
            Fault::new(format!("--runtime `{argument}`: expected PLATFORM=FILE with PLATFORM {}", choice()))
                .of("--runtime")
        })?;
        RuntimeLibrary::read(platform, Path::new(file))
    }

    /// Reads and checks a library.
    pub fn read(platform: &str, path: &Path) -> Result<Self, Fault> {
        let (platform, _) = PLATFORMS
            .into_iter()
            .find(|(name, _)| *name == platform)
            .ok_or_else(|| Fault::new(format!("`{platform}` is not a platform of FMI 2.0; expected {}", choice())))?;
        if path.exists() && !path.is_file() {
            return Err(Fault::new(format!("{} is not a file", path.display())));
        }
        let bytes = std::fs::read(path)
            .map_err(|e| Fault::new(format!("{} cannot be read: {}", path.display(), reason(&e))))?;
        if !is_library_for(platform, &bytes) {
            return Err(Fault::new(format!(
                "{} is not a shared library for {platform}; it is {}",
                path.display(),
                describe(&bytes)
            )));
        }
        if !contains(&bytes, LANDMARK) {
            return Err(Fault::new(format!(
                "{} does not export fmi2DoStep, so it is not a runtime library of camdrive. Build one with \
                 `{BUILD_COMMAND}`",
                path.display()
            )));
        }
        if !contains(&bytes, BUILD.as_bytes()) {
            return Err(Fault::new(format!(
                "{} is built from other sources than this executable ({}). Rebuild it with `packaging/build`, or \
                 with `{BUILD_COMMAND}` on its platform",
                path.display(),
                BUILD
            )));
        }
        Ok(RuntimeLibrary { platform, path: path.to_owned(), bytes })
    }

    /// The path inside the FMU of the library of the model `identifier`.
    pub fn path_in_fmu(&self, identifier: &str) -> String {
        let suffix = PLATFORMS.iter().find(|(name, _)| *name == self.platform).map_or("", |(_, suffix)| suffix);
        format!("binaries/{}/{identifier}{suffix}", self.platform)
    }

    /// SHA-256 in hexadecimal.
    pub fn sha256(&self) -> String {
        super::hash::hexadecimal(&sha256(&self.bytes))
    }

    /// A remark for users who ship the FMU.
    pub fn warning(&self) -> Option<String> {
        (self.bytes.len() > LARGEST_RELEASE).then(|| {
            format!(
                "{} takes {:.1} MB: a debug or unstripped build. For a small and fast FMU build it with `{BUILD_COMMAND}`",
                self.path.display(),
                self.bytes.len() as f64 / 1e6
            )
        })
    }
}

fn executable() -> Result<PathBuf, Fault> {
    let executable = std::env::current_exe();
    // macOS reports the link by which a program was called, if its installer made one.
    let executable =
        if cfg!(target_os = "macos") { executable.and_then(|path| path.canonicalize()) } else { executable };
    executable.map_err(|e| Fault::new(format!("the running executable cannot be located ({e}); use --runtime")))
}

fn missing(platform: &str) -> Fault {
    Fault::new(format!(
        "there is no runtime library for {platform} in the folder `runtimes` beside this executable or above it. \
         `packaging/build` makes the libraries for linux64, aarch64-linux, win64 and Darwin; --runtime {platform}=FILE names any"
    ))
}

fn contains(bytes: &[u8], text: &[u8]) -> bool {
    bytes.windows(text.len()).any(|window| window == text)
}

fn choice() -> String {
    PLATFORMS.map(|(name, _)| name).join(" | ")
}

/// FMI 2.0 names only the operating system and word length; importers look for the processor's own folder if there is one.
fn host_platform() -> Option<&'static str> {
    let wide = cfg!(target_pointer_width = "64");
    match std::env::consts::OS {
        "linux" if cfg!(target_arch = "aarch64") => Some("aarch64-linux"),
        "linux" => Some(if wide { "linux64" } else { "linux32" }),
        "windows" => Some(if wide { "win64" } else { "win32" }),
        "macos" => Some(if wide { "darwin64" } else { "darwin32" }),
        _ => None,
    }
}

/// Kind of a file by its first bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Binary {
    platforms: Vec<&'static str>,
    shared: bool,
}

fn is_library_for(platform: &str, bytes: &[u8]) -> bool {
    binary(bytes).is_some_and(|b| b.shared && b.platforms.contains(&platform))
}

fn describe(bytes: &[u8]) -> String {
    match binary(bytes) {
        None => "not an ELF, PE or Mach-O file".to_owned(),
        Some(b) if b.platforms.is_empty() => "for another processor".to_owned(),
        Some(b) => format!(
            "{} for {}",
            if b.shared { "a shared library" } else { "an executable or object file" },
            b.platforms.join(" and ")
        ),
    }
}

fn little_endian(bytes: &[u8], at: usize, length: usize) -> Option<usize> {
    let field = bytes.get(at..at.checked_add(length)?)?;
    Some(field.iter().rev().fold(0, |sum, byte| (sum << 8) | usize::from(*byte)))
}

/// True if one of the program headers of an ELF file is PT_INTERP (3).
fn has_interpreter(bytes: &[u8], wide: bool) -> bool {
    let number = |at, length| little_endian(bytes, at, length);
    // e_phoff, e_phentsize and e_phnum.
    let (offset, size, count) = if wide {
        (number(32, 8), number(54, 2), number(56, 2))
    } else {
        (number(28, 4), number(42, 2), number(44, 2))
    };
    let (Some(offset), Some(size), Some(count)) = (offset, size, count) else { return false };
    (0..count).any(|i| offset.checked_add(i * size).and_then(|at| number(at, 4)) == Some(3))
}

/// Reads the headers of ELF, PE/COFF and (thin or universal) Mach-O files.
fn binary(bytes: &[u8]) -> Option<Binary> {
    let number = |at, length| little_endian(bytes, at, length);
    let of =
        |platform: Option<&'static str>, shared| Some(Binary { platforms: platform.into_iter().collect(), shared });
    match bytes.get(..4)? {
        // e_ident[EI_CLASS] = 2: 64 bit; e_type = 3: shared object. Most executables are shared objects as well, but they name an
        // interpreter.
        [0x7f, b'E', b'L', b'F'] => {
            let platform = match number(18, 2)? {
                3 => Some("linux32"),
                62 => Some("linux64"),
                183 => Some("aarch64-linux"),
                _ => None,
            };
            of(platform, number(16, 2)? == 3 && !has_interpreter(bytes, bytes.get(4) == Some(&2)))
        }
        // The COFF header follows the signature at the offset stored at 0x3c; 0x2000 is IMAGE_FILE_DLL.
        [b'M', b'Z', ..] => {
            let pe = number(0x3c, 4)?;
            if bytes.get(pe..pe.checked_add(4)?)? != b"PE\0\0" {
                return None;
            }
            let platform = match number(pe + 4, 2)? {
                0x014c => Some("win32"),
                0x8664 => Some("win64"),
                _ => None,
            };
            of(platform, number(pe + 22, 2)? & 0x2000 != 0)
        }
        // filetype 6: MH_DYLIB.
        [0xce | 0xcf, 0xfa, 0xed, 0xfe] => {
            let platforms = processor(number(4, 4)?).to_vec();
            Some(Binary { platforms, shared: number(12, 4)? == 6 })
        }
        // A universal file: a big-endian table of processors and places, 20 bytes for each.
        [0xca, 0xfe, 0xba, 0xbe] => {
            let table = bytes.get(8..)?.chunks_exact(20).take(usize::from(*bytes.get(7)?));
            let parts = table.map(|part| u32::from_be_bytes([part[0], part[1], part[2], part[3]]) as usize);
            let mut platforms: Vec<_> = parts.flat_map(processor).copied().collect();
            platforms.sort_unstable();
            platforms.dedup();
            Some(Binary { platforms, shared: true })
        }
        _ => None,
    }
}

/// The platforms of a Mach-O processor type. FMI 2.0 does not distinguish processors, so importers on both look into darwin64.
fn processor(kind: usize) -> &'static [&'static str] {
    match kind {
        7 => &["darwin32"],
        0x0100_0007 => &["darwin64"],
        0x0100_000c => &["darwin64", "aarch64-darwin"],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The start of a 64 bit ELF file of this type.
    fn elf(kind: u8) -> Vec<u8> {
        let mut bytes = b"\x7fELF\x02\x01\x01".to_vec();
        bytes.resize(16, 0);
        bytes.extend([kind, 0, 62, 0]);
        bytes
    }

    fn pe(characteristics: u16) -> Vec<u8> {
        let mut bytes = b"MZ".to_vec();
        bytes.resize(0x3c, 0);
        bytes.extend(0x80u32.to_le_bytes());
        bytes.resize(0x80, 0);
        bytes.extend(b"PE\0\0\x64\x86");
        bytes.resize(0x80 + 22, 0);
        bytes.extend(characteristics.to_le_bytes());
        bytes
    }

    #[test]
    fn the_headers_tell_platform_and_kind() {
        assert!(is_library_for("linux64", &elf(3)));
        assert!(!is_library_for("linux32", &elf(3)));
        assert!(!is_library_for("linux64", &elf(1)));
        // A modern executable: a shared object with one program header, at byte 64, that names an interpreter.
        let mut executable = elf(3);
        executable.resize(120, 0);
        (executable[32], executable[54], executable[56], executable[64]) = (64, 56, 1, 3);
        assert!(!is_library_for("linux64", &executable));
        executable[64] = 1;
        assert!(is_library_for("linux64", &executable));
        assert!(is_library_for("win64", &pe(0x2022)));
        assert!(!is_library_for("win64", &pe(0x0022)));
        let mach = |processor| [0xcf, 0xfa, 0xed, 0xfe, processor, 0, 0, 1, 3, 0, 0, 0, 6, 0, 0, 0];
        assert!(is_library_for("darwin64", &mach(7)) && !is_library_for("aarch64-darwin", &mach(7)));
        assert!(is_library_for("darwin64", &mach(12)) && is_library_for("aarch64-darwin", &mach(12)));
        let mut universal = [0xca, 0xfe, 0xba, 0xbe, 0, 0, 0, 2].to_vec();
        for processor in [7, 12] {
            universal.extend([1, 0, 0, processor]);
            universal.resize(universal.len() + 16, 0);
        }
        assert!(is_library_for("darwin64", &universal) && is_library_for("aarch64-darwin", &universal));
        let mut arm = elf(3);
        arm[18] = 183;
        assert!(is_library_for("aarch64-linux", &arm) && !is_library_for("linux64", &arm));
        arm[18] = 243;
        assert!(!is_library_for("linux64", &arm) && describe(&arm) == "for another processor");
    }

    #[test]
    fn damaged_headers_are_no_library() {
        for whole in [elf(3), pe(0x2022)] {
            for length in 0..whole.len() - 3 {
                assert!(binary(&whole[..length]).is_none_or(|b| !b.shared), "{length} bytes");
            }
        }
        let mut far = pe(0x2022);
        far[0x3c..0x40].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(binary(&far), None);
    }

    #[test]
    fn a_library_of_something_else_is_refused() {
        let folder = std::env::temp_dir().join(format!("camdrive-runtime-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("lib.so");
        std::fs::write(&path, elf(3)).unwrap();
        let read = |argument: String| RuntimeLibrary::from_argument(&argument).map_err(|fault| fault.0.message);
        assert!(read(format!("linux64={}", path.display())).unwrap_err().contains("does not export fmi2DoStep"));
        assert!(read(format!("win64={}", path.display())).unwrap_err().contains("a shared library for linux64"));
        assert!(read(format!("amiga={}", path.display())).unwrap_err().contains("linux64 | linux32"));
        assert!(read("linux64".to_owned()).unwrap_err().contains("PLATFORM=FILE"));
        assert!(read("linux64=".to_owned()).unwrap_err().contains("PLATFORM=FILE"));
        std::fs::write(&path, [elf(3), b"\0fmi2DoStep\0".to_vec()].concat()).unwrap();
        let other = read(format!("linux64={}", path.display())).unwrap_err();
        assert!(other.contains("from other sources") && other.contains("packaging/build"), "{other}");
        std::fs::write(&path, [&elf(3), &b"\0fmi2DoStep\0"[..], BUILD.as_bytes()].concat()).unwrap();
        let library = read(format!("linux64={}", path.display())).unwrap();
        assert_eq!(library.path_in_fmu("Sley"), "binaries/linux64/Sley.so");
        assert_eq!(library.warning(), None);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
