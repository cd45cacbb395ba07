//! The help of the tool, with its commands in groups.

use clap::Command;

/// What a group is for, and the names of its commands.
type Group = (&'static str, &'static [&'static str]);

const GROUPS: [Group; 5] = [
    ("Make a tile file", &["info", "build", "task", "overviews", "generate"]),
    (
        "Change it",
        &[
            "insert",
            "delete",
            "move",
            "set-z",
            "constrain",
            "unconstrain",
            "checkpoint",
            "compact",
        ],
    ),
    ("Use it", &["query", "export", "serve"]),
    ("Examine it", &["inspect", "verify", "digest", "bench"]),
    ("Set up the shell", &["completions", "man"]),
];

/// Returns the command of the tool, whose help lists its commands by group.
pub fn grouped(tool: Command) -> Command {
    let commands = listed(&tool);
    tool.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{commands}Options:\n{{options}}{{after-help}}"
    ))
}

/// Returns the list of the commands. Without a feature, some are not there.
fn listed(tool: &Command) -> String {
    let mut text = String::new();
    for (heading, names) in GROUPS {
        text += &format!("{heading}:\n");
        for command in names.iter().filter_map(|name| tool.find_subcommand(name)) {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            text += &format!("  {:13}{about}\n", command.get_name());
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn each_command_is_in_one_group_on_one_line() {
        let tool = crate::Cli::command();
        let text = listed(&tool);
        for command in tool.get_subcommands() {
            let line = format!("\n  {:13}", command.get_name());
            assert_eq!(text.matches(&line).count(), 1, "{}", command.get_name());
        }
        assert!(text.lines().all(|line| line.len() <= 84), "{text}");
    }
}
