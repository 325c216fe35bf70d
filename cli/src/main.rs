fn main() -> std::process::ExitCode {
    camdrive_cli::command::main()
}
