//! Kills at random moments while the window saves.

use super::*;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

/// Environment variable of the process to be killed: the scene that it saves.
const VICTIM: &str = "PATHMARCH_TEST_VICTIM";
/// Environment variable with the number of kills, 10 by default.
const COUNT: &str = "PATHMARCH_TEST_KILLS";
/// Length of the longest text, bytes: one that takes a while to write.
const LONGEST: usize = 400_000;

/// Text of a save: valid, of its own length, with its number at both ends.
fn text(number: usize) -> String {
    let padding = "// and a long comment\n".repeat(number * 7919 % (LONGEST / 22));
    format!("// save {number}\n{SCENE}{padding}// save {number}\n")
}

/// Number of the save whose text this is, if it is whole.
fn number_of(found: &str) -> Option<usize> {
    let number = found.lines().next()?.strip_prefix("// save ")?.parse().ok()?;
    (found == text(number)).then_some(number)
}

/// Edits and saves without end, and prints the number of each save.
fn save_without_end(file: PathBuf) {
    let directory = Arc::new(tempfile::tempdir().expect("a directory"));
    let first = number_of(&std::fs::read_to_string(&file).expect("read")).expect("whole");
    let mut person = Start { directory, scene: Some(file), ..Start::new() }.go();
    for number in first + 1.. {
        person.app_mut().edit(|open| {
            open.document.replace_text(text(number), "Test", None);
            Ok(())
        });
        person.ctrl(Key::S);
        assert!(!person.open().has_unsaved_work(), "{:?}", person.messages());
        println!("\nsaved {number}");
        std::io::stdout().flush().expect("printed");
    }
}

#[test]
fn a_kill_while_saving_leaves_the_old_text_or_the_new() {
    if let Some(file) = std::env::var_os(VICTIM) {
        return save_without_end(file.into());
    }
    let count = std::env::var(COUNT).ok().and_then(|count| count.parse().ok()).unwrap_or(10);
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("scene.kdl");
    std::fs::write(&file, text(0)).expect("written");
    let (mut during, mut saves) = (0, 0);
    for kill in 0..count {
        let mut victim = Command::new(std::env::current_exe().expect("this program"))
            .args([
                "--exact",
                "window::tests::kills::a_kill_while_saving_leaves_the_old_text_or_the_new",
                "--nocapture",
            ])
            .env(VICTIM, &file)
            .env("TMPDIR", directory.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("started");
        let mut lines = BufReader::new(victim.stdout.take().expect("a pipe")).lines();
        let mut next = || lines.find_map(|line| line.ok()?.strip_prefix("saved ")?.parse::<usize>().ok());
        let mut saved = next().expect("it saves");
        // Golden ratio: the moments spread evenly over a tenth of a second.
        std::thread::sleep(Duration::from_secs_f64((f64::from(kill) * 0.618_034).fract() * 0.1));
        victim.kill().expect("killed");
        victim.wait().expect("ended");
        while let Some(number) = next() {
            saved = number;
        }
        let found = std::fs::read_to_string(&file).expect("read");
        let number = number_of(&found).unwrap_or_else(|| panic!("kill {kill} tore the file of {} bytes", found.len()));
        assert!(number == saved || number == saved + 1, "kill {kill}: {saved} was saved, {number} is there");
        during += number - saved;
        saves = number;
    }
    println!("{count} kills, {saves} saves, {during} of them finished but not yet reported");
}
