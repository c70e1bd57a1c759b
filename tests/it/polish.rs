//! What a person at the keyboard meets: suggestions, colours, completions, manual pages.

use std::path::Path;

use assert_cmd::Command;

struct Said {
    code: i32,
    out: String,
    err: String,
}

fn roadbench(folder: &Path, arguments: &[&str], variables: &[(&str, &str)]) -> Said {
    let output = Command::cargo_bin("roadbench")
        .expect("binary")
        .current_dir(folder)
        .args(arguments)
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR_FORCE")
        .envs(variables.iter().copied())
        .output()
        .expect("ran");
    Said {
        code: output.status.code().expect("not killed"),
        out: String::from_utf8(output.stdout).expect("text"),
        err: String::from_utf8(output.stderr).expect("text"),
    }
}

#[test]
fn what_is_misspelt_is_guessed() {
    let folder = tempfile::tempdir().expect("folder");
    let put = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("file");
        name.to_owned()
    };
    let settings = put("p.toml", "name = 'x'\n[filter]\nhigh_cutt = 3\n");
    let map =
        put("m.toml", "name = 'x'\nformat = 'csv'\n[time]\nrate = 10\n[channel.rol]\nfrom = 'x'\n");
    let log = put("l.csv", "x\n1\n2\n");
    let scenario = put(
        "s.toml",
        &roadbench::internals::simulate::scenario::BUILTIN[0]
            .1
            .replace("[disturbance]", "[effects]\nsteer_zro = 0.1\n[disturbance]"),
    );
    for (arguments, guess) in [
        (&["rum"][..], "run"),
        (&["schema", "coeficients"], "`coefficients`"),
        (&["simulate", "naturalistik", "--out", "x"], "`naturalistic`"),
        (&["simulate", "lane_chnage", "--out", "x"], "`lane_change`"),
        (&["simulate", &scenario, "--out", "x"], "`steer_zero`"),
        (&["plan", "papr"], "`paper`"),
        (&["tyre", "sharp2004_frnt_120_70"], "`sharp2004_front_120_70`"),
        (&["modes", "sports_tuoring"], "`sports_touring`"),
        (&["run", ".", "--out", "x", "--pipeline", "offraod"], "`offroad`"),
        (&["run", ".", "--out", "x", "--pipeline", &settings], "did you mean"),
        (&["convert", &log, "--map", &map, "--dry-run"], "`roll`"),
        (&["export", ".", "--session", "s", "--format", "simulater"], "simulator"),
    ] {
        let said = roadbench(folder.path(), arguments, &[]);
        assert_eq!(said.code, 2, "{arguments:?}: {}", said.err);
        assert!(said.err.contains(guess), "{arguments:?}: {}", said.err);
    }
}

#[test]
fn colours_follow_the_conventions() {
    let folder = tempfile::tempdir().expect("folder");
    let coloured = |variables: &[(&str, &str)]| {
        // ours, and the argument parser's
        let ours = roadbench(folder.path(), &["schema", "x"], variables).err;
        let parsers = roadbench(folder.path(), &["rum"], variables).err;
        [ours.contains('\u{1b}'), parsers.contains('\u{1b}')]
    };
    assert_eq!(coloured(&[]), [false; 2], "not off a terminal");
    assert_eq!(coloured(&[("CLICOLOR_FORCE", "1")]), [true; 2]);
    assert_eq!(coloured(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]), [false; 2]);
}

#[test]
fn shells_and_man_know_every_command() {
    let folder = tempfile::tempdir().expect("folder");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let said = roadbench(folder.path(), &["completions", shell], &[]);
        assert_eq!(said.code, 0, "{}", said.err);
        for word in ["diagnose", "export", "--format", "motorcycle", "--no-open"] {
            let word = if shell == "fish" { word.trim_start_matches('-') } else { word };
            assert!(said.out.contains(word), "{shell}: {word}");
        }
        // a shell that is here reads its own
        let script = folder.path().join("script");
        std::fs::write(&script, &said.out).expect("script");
        if let Ok(checked) = std::process::Command::new(shell).arg("-n").arg(&script).output()
            && matches!(shell, "bash" | "zsh" | "fish")
        {
            assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
        }
    }
    let said = roadbench(folder.path(), &["man", "pages"], &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    let mut pages = 0;
    for page in std::fs::read_dir(folder.path().join("pages")).expect("pages") {
        let page = page.expect("page").path();
        let text = std::fs::read_to_string(&page).expect("page");
        assert!(text.contains(".TH") && text.contains("roadbench"), "{}", page.display());
        assert!(text.contains("Example"), "{} shows no example", page.display());
        pages += 1;
    }
    assert!(said.out.starts_with(&format!("{pages} pages")) && pages >= 16, "{}", said.out);
}
