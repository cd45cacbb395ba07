//! The promise: the tool takes each command that a page or a help text shows.

use std::fs;
use std::path::Path;

use clap::{Command, CommandFactory};

use super::Cli;

/// Returns the commands of the tool in a text, in the words of a shell: lines that begin with its name, or
/// with `$` and its name, to the end of the line or to what the shell takes.
fn commands(text: &str) -> Vec<Vec<String>> {
    let text = text.replace("\\\n", " ");
    let lines = text.lines().map(|line| line.trim_start().trim_start_matches("$ "));
    let of_tool = lines.filter(|line| line.starts_with("tiletool "));
    let words = |line: &str| {
        let words = shlex::split(line).unwrap_or_else(|| panic!("a quote is open in: {line}"));
        let is_shell = |word: &String| matches!(&**word, "|" | "&" | "&&" | ";" | ">" | "2>" | "<");
        // Variables that the pages use are numbers.
        let value = |word: String| if word.starts_with('$') { "1".to_owned() } else { word };
        words
            .into_iter()
            .take_while(|word| !is_shell(word))
            .map(value)
            .collect()
    };
    of_tool.map(words).collect()
}

/// Returns the text of the blocks between fences of a page.
fn blocks(page: &str) -> String {
    page.split("\n```").skip(1).step_by(2).collect::<Vec<_>>().join("\n")
}

/// Returns the examples of a command's help, and of those below it.
fn examples(command: &Command) -> String {
    let below: String = command.get_subcommands().map(examples).collect();
    let own = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    format!("{own}\n{below}")
}

fn refused(text: &str) -> Vec<String> {
    let refused = |words: Vec<String>| {
        let error = Cli::command().try_get_matches_from(&words).err()?;
        let is_wrong = error.use_stderr();
        is_wrong.then(|| format!("{}\n{error}", words.join(" ")))
    };
    commands(text).into_iter().filter_map(refused).collect()
}

#[test]
fn commands_of_pages_are_taken() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages: Vec<_> = fs::read_dir(root.join("docs"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    pages.push(root.join("README.md"));
    let mut count = 0;
    for page in pages {
        let text = blocks(&fs::read_to_string(&page).unwrap());
        count += commands(&text).len();
        let refused = refused(&text);
        assert!(refused.is_empty(), "{}: {}", page.display(), refused.join("\n"));
    }
    assert!(count > 100, "only {count} commands were found");
}

#[test]
fn examples_of_help_texts_are_taken() {
    let text = examples(&Cli::command());
    let refused = refused(&text);
    assert!(refused.is_empty(), "{}", refused.join("\n"));
    assert!(
        commands(&text).len() > 40,
        "{} examples were found",
        commands(&text).len()
    );
}
