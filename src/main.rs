fn main() -> std::process::ExitCode {
    camdrive::cli::main()
}
