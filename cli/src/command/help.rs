//! `camdrive help [COMMAND | scene | task | study | system] [SECTION]`

use super::output::show;
use super::{Cli, Failure, wrong_argument};
use crate::document::{Kind, reference::tables};
use clap::{CommandFactory, ValueEnum};

/// Explain a command, or the keys of a section of scenes or tasks.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive help export
  camdrive help scene
  camdrive help scene elasticity")]
pub struct Args {
    /// A command, or `scene`, `task`, `study` or `system`
    subject: Option<String>,
    /// One of its sections
    section: Option<String>,
}

/// The commands, grouped by the question they answer.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Write and check a scene", &["new", "check", "describe"]),
    ("How does it move?", &["steady", "run", "stability", "clearance", "forces"]),
    ("Which law, which cam?", &["synthesize", "compensate", "cam"]),
    ("How do variants and settings compare?", &["study", "tradeoff"]),
    ("Pages, FMUs and systems", &["report", "export", "verify", "system"]),
    ("For your shell and editor", &["schema", "completions", "help"]),
];

/// The command line; its help lists the commands in groups.
pub fn command() -> clap::Command {
    let commands = Cli::command();
    let mut list = String::new();
    for (question, names) in GROUPS {
        list += &format!("{question}\n");
        for name in names {
            let about = commands.find_subcommand(name).and_then(|command| command.get_about());
            let about = about.map_or(String::new(), ToString::to_string);
            list += &format!("  {name:<12} {about}\n");
        }
        list.push('\n');
    }
    let template = format!("{{about}}\n\n{{usage-heading}} {{usage}}\n\n{list}Options:\n{{options}}{{after-help}}");
    commands.help_template(template)
}

/// The help of the tool.
pub fn overview() -> String {
    command().render_help().to_string()
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let mut commands = Cli::command();
    commands.build();
    let Some(subject) = &args.subject else { return show(&overview()) };
    let Ok(kind) = Kind::from_str(subject, false) else {
        let command = commands.find_subcommand_mut(subject);
        let unknown = || {
            wrong_argument(format!("there is no command {subject}"))
                .hint("`camdrive help` lists them, and `scene`, `task`, `study` and `system`")
        };
        return show(&command.ok_or_else(unknown)?.render_long_help().to_string());
    };
    let all = tables(kind);
    let name = |title: &str| title.replace(['`', '[', ']'], "");
    let Some(section) = &args.section else {
        let names: Vec<String> = all[1..].iter().map(|table| name(table.title)).collect();
        // Study and system are commands, too.
        let command = commands.find_subcommand_mut(subject).map(|command| format!("{}\n", command.render_long_help()));
        let command = command.unwrap_or_default();
        return show(&format!("{command}{}\nsections: {}\n", all[0].text(), names.join(", ")));
    };
    let asked = |section: &str| -> Vec<String> {
        let is_it = |title: &str| title.split([' ', ',', '.']).any(|word| word == section) || title == section;
        all.iter().filter(|table| is_it(&name(table.title))).map(|table| table.text()).collect()
    };
    // A section may be written as in scenes: [follower.load].
    let section = section.trim_matches(['[', ']']);
    let whole = asked(section);
    let text = if whole.is_empty() { asked(section.rsplit('.').next().unwrap_or_default()) } else { whole };
    if text.is_empty() {
        let files = if kind == Kind::Study { "studies".to_owned() } else { format!("{subject}s") };
        return Err(wrong_argument(format!("{files} have no section {section}"))
            .hint(format!("`camdrive help {subject}` lists them")));
    }
    show(&text.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_answers_one_question() {
        let all: Vec<String> = Cli::command().get_subcommands().map(|command| command.get_name().to_owned()).collect();
        for name in &all {
            let count = GROUPS.iter().filter(|(_, names)| names.contains(&name.as_str())).count();
            assert_eq!(count, 1, "{name}");
        }
        assert_eq!(GROUPS.iter().map(|(_, names)| names.len()).sum::<usize>(), all.len());
        assert!(overview().contains("\n  steady       Find the periodic motion"), "{}", overview());
    }
}
