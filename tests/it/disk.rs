//! A disk that fills up under a run.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use roadbench::internals::batch::Error;

use crate::script::{Place, Script, adds_up};

/// A file system of a few kilobytes; taken away at the end.
pub struct Small(pub PathBuf);

impl Small {
    /// `None` where nobody may mount one.
    pub fn new(place: &Place, size: &str) -> Option<Self> {
        let folder = place.path("small");
        std::fs::create_dir_all(&folder).expect("folder");
        mount(&["-t", "tmpfs", "-o", &format!("size={size}"), "tmpfs"], &folder)
            .then_some(Small(folder))
    }

    fn grow(&self, size: &str) -> bool {
        mount(&["-o", &format!("remount,size={size}")], &self.0)
    }
}

impl Drop for Small {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).stderr(Stdio::null()).status();
    }
}

fn mount(options: &[&str], folder: &std::path::Path) -> bool {
    let mut command = Command::new("mount");
    command.args(options).arg(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

#[test]
fn a_full_disk_is_one_clear_error_and_loses_nothing() {
    let logs: Vec<(String, String)> =
        (0..30).map(|i| (format!("l{i:02}"), format!("s{i:02}|b1|ok"))).collect();
    let logs: Vec<(&str, &str)> = logs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let place = Place::new(&logs);
    let Some(small) = Small::new(&place, "256k") else {
        println!("skipped: no file system may be mounted here");
        return;
    };
    let run = || place.run_with(&Script::default(), |s| s.out = place.path("small/out"));
    let error = run().expect_err("256 kB do not hold 30 sessions");
    let Error::Output(message) = &error else { panic!("{error:?}") };
    assert!(message.contains("No space left") && message.contains("small/out"), "{message}");
    // what is there is whole, and counts
    let there = place.tables("small/out");
    assert!(there.keys().any(|name| name.ends_with(".session")), "nothing came through");
    for (name, bytes) in there.iter().filter(|(name, _)| !name.ends_with(".tmp")) {
        assert!(bytes.ends_with(b"PAR1"), "{name} is not whole");
    }
    assert!(small.grow("64m"), "the file system grows");
    let rest = run().expect("room enough");
    adds_up(&rest);
    assert!(rest.unchanged > 0 && rest.done > 0, "{rest:?}");
    place.run();
    assert!(place.tables("small/out") == place.tables("out"), "not what an undisturbed run writes");
}
