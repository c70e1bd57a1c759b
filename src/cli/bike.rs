//! `roadbench bike new`: a bike file from what its owner knows.

use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};

use crate::cli::examples::BIKE;
use crate::cli::failure::Failure;
use crate::cli::say::{self, note, say, tell};
use crate::contract::bike::{Axle, schema};
use crate::motorcycle::catalogue::file::{cost_of, rounded, text};
use crate::motorcycle::catalogue::numbers::{Origin, twice};
use crate::motorcycle::catalogue::owner::Portrait;
use crate::motorcycle::catalogue::{Catalogue, Owner, TyreSize};
use crate::report::terminal::wrapped;
use crate::store::tables::names::is_plain;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;

/// Write the bike file of a motorcycle or bicycle
#[derive(Debug, clap::Args)]
#[command(disable_help_subcommand = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    #[command(after_help = BIKE)]
    New(New),
}

/// Write a bike file from class, tyre sizes and weight; asks for the rest
#[derive(Debug, clap::Args)]
pub(crate) struct New {
    /// The bike id that logs carry; the file is DIR/NAME.toml. `default` is taken for bikes that have no file.
    name: Option<String>,
    /// Class: sports, naked, touring, off-road, scooter, bicycle, e-bike.
    #[arg(long, value_name = "CLASS")]
    class: Option<String>,
    /// Make and model; a few are known with their data sheets, the others need a class.
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Front tyre as printed: 120/70ZR17, 90/90-21, 3.50-18, 37-622.
    #[arg(long, value_name = "SIZE")]
    front: Option<String>,
    /// Rear tyre as printed.
    #[arg(long, value_name = "SIZE")]
    rear: Option<String>,
    /// Weight of motorcycle and rider in gear, kg.
    #[arg(long, value_name = "KG", value_parser = kilograms)]
    weight: Option<f64>,
    /// Loads of front and rear wheel on scales, rider seated, kg: gives mass and place of the centre of mass.
    #[arg(long, value_name = "FRONT,REAR", value_parser = list::<2>)]
    scales: Option<[f64; 2]>,
    /// How far the rear axle was lifted, m, and the front wheel's load then, kg: gives the height of the centre of mass.
    #[arg(long, value_name = "LIFT,FRONT", value_parser = list::<2>)]
    lifted: Option<[f64; 2]>,
    /// Front wheel swung about a bar inside its rim: mass kg, bar to axle m, period s; gives its spin inertia.
    #[arg(long, value_name = "MASS,ARM,PERIOD", value_parser = list::<3>)]
    swung_front: Option<[f64; 3]>,
    /// The same of the rear wheel.
    #[arg(long, value_name = "MASS,ARM,PERIOD", value_parser = list::<3>)]
    swung_rear: Option<[f64; 3]>,
    /// A key of the bike file that you know, with its standard deviation or without: cg_height=0.60+-0.02; may be
    /// repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Folder of bike files.
    #[arg(short, long, value_name = "DIR", default_value = "bikes", value_hint = ValueHint::DirPath)]
    out: PathBuf,
    /// Write over a file that is there.
    #[arg(long)]
    force: bool,
}

/// A weight: a bare number.
fn kilograms(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    number.ok_or_else(|| "write kg with a point and without the unit, such as 270.5".to_owned())
}

/// Numbers with commas between them.
fn list<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    let finite = numbers.iter().all(|x| x.is_finite()) && text.split(',').count() == N;
    let all = <[f64; N]>::try_from(numbers).ok().filter(|_| finite);
    let example = ["125.5", "135", "1.3"][..N.min(3)].join(",");
    all.ok_or_else(|| {
        format!("write {N} numbers with commas between them and without units, such as {example}")
    })
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    let Command::New(new) = arguments.command;
    Outputs::default().folder("--out", &(&new.out).into())?;
    let catalogue = Catalogue::builtin();
    let (mut owner, mut wrong) = known(&new);
    let terminal = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
    let mut name = new.name.clone();
    let asks = terminal && wrong.is_empty() && (name.is_none() || lacks(&owner, catalogue));
    if asks {
        let (input, output) = (std::io::stdin(), std::io::stdout());
        let mut asked = Interview { input: &mut input.lock(), output: &mut output.lock() };
        asked
            .about(&mut name, &mut owner, catalogue)
            .map_err(|e| Failure::Output(format!("cannot ask: {e}")))?;
    }
    match &name {
        None => wrong.push("give the NAME that the logs know the bike by".to_owned()),
        Some(name) => wrong.extend(bad_name(name)),
    }
    let portrait = owner.portrait(catalogue).map_err(|e| wrong.push(e.to_string())).ok();
    let (Some(portrait), Some(name), true) = (portrait, name, wrong.is_empty()) else {
        return Err(Failure::Usage(wrong.join("; ")));
    };
    let text = text(&portrait, &name).map_err(Failure::usage)?;
    let path = new.out.join(format!("{name}.toml"));
    write(&path, &text, new.force)?;
    if !say::is_quiet() {
        summary(&portrait, &path);
    }
    for doubt in portrait.doubts() {
        tell!("{}", wrapped(&format!("warning: {doubt}"), say::line_width()));
    }
    if name == "default" {
        note!("\nBikes without a file of their own are now taken as this one, with a warning.");
    } else {
        note!("\nNext: roadbench run LOG --bikes {} --out out", new.out.display());
        note!(
            "A log that does not say that it is of {name}: roadbench convert LOG --bike {name} --out ride.parquet"
        );
    }
    Ok(())
}

/// What the options say, and what is wrong with them.
fn known(new: &New) -> (Owner, Vec<String>) {
    let mut owner = Owner {
        class: new.class.clone(),
        model: new.model.clone(),
        sizes: [new.front.clone(), new.rear.clone()],
        weight: new.weight,
        scales: new.scales,
        lifted: new.lifted,
        swung: [new.swung_front, new.swung_rear],
        ..Owner::default()
    };
    let schema = schema();
    let wrong = |text: &String| {
        let before = owner.measured.clone();
        let Err(why) = owner.set(text, schema) else {
            return before.iter().find_map(|(key, was)| {
                let values = [(was.value, "first"), (owner.measured[key].value, "then")];
                twice(key, values)
            });
        };
        Some(option_of(text).unwrap_or_else(|| why.to_string()))
    };
    let wrong = new.set.iter().filter_map(wrong).collect();
    if let (Some(model), false) = (&new.model, owner.texts.contains_key("name")) {
        owner.texts.insert("name".to_owned(), model.clone());
    }
    (owner, wrong)
}

/// What to write instead of `--set class=naked`.
fn option_of(text: &str) -> Option<String> {
    let (key, value) = text.split_once('=')?;
    let (key, value) = (key.trim(), value.trim());
    let option = key.replace(['_', '.'], "-");
    let all = New::augment_args(clap::Command::new("new"));
    let is_option = all.get_arguments().any(|a| a.get_long() == Some(option.as_str()));
    is_option.then(|| format!("`{key}` is an option of its own: --{option} {value}"))
}

/// Whether something is left to ask for.
fn lacks(owner: &Owner, catalogue: &Catalogue) -> bool {
    let model = owner.model.as_deref().and_then(|m| catalogue.model(m));
    let weighed = owner.weight.is_some() || owner.scales.is_some();
    let sized = model.is_some() || owner.sizes.iter().all(Option::is_some);
    (owner.class.is_none() && model.is_none()) || !sized || !weighed
}

/// What is wrong with a bike id, if anything is.
pub(super) fn bad_name(name: &str) -> Option<String> {
    let good = is_plain(name) && !name.is_empty() && name.len() <= 100;
    (!good).then(|| {
        let name = name.escape_debug();
        format!("`{name}` cannot be a bike id: letters, digits, `.`, `_` and `-`, at most 100")
    })
}

fn write(path: &Path, text: &str, force: bool) -> Result<(), Failure> {
    if path.exists() && !force {
        let at = path.display();
        return Err(Failure::Usage(format!("{at} exists already; --force overwrites it")));
    }
    Outputs::default().file("--out", &path.into())?;
    output::write(path, text.as_bytes()).map_err(|e| Failure::Output(e.to_string()))
}

/// Every number in a line, and what the guesses cost.
fn summary(portrait: &Portrait, path: &Path) {
    let schema = schema();
    for n in &portrait.numbers {
        let key = schema.keys.iter().find(|k| k.path == n.key);
        let unit = key.and_then(|k| k.unit.as_deref()).filter(|u| *u != "1").unwrap_or("");
        let value = rounded(n.known.value, n.known.sd);
        let sd = if n.known.sd > 0.0 { rounded(n.known.sd, n.known.sd) } else { "0".into() };
        let cost = if n.origin.is_guess() { cost_of(n) } else { None };
        let cost = cost.map(|c| format!("; costs {c}")).unwrap_or_default();
        let (key, origin) = (&n.key, n.origin.name());
        let line = format!("{key:31} {value:>10} ± {sd:<9} {unit:7} {origin}{cost}");
        say!("{}", wrapped(&line, say::line_width()).trim_end());
    }
    let count =
        |is: &dyn Fn(&Origin) -> bool| portrait.numbers.iter().filter(|n| is(&n.origin)).count();
    let printed = count(&|o: &Origin| o.is_printed());
    let guesses = count(&|o: &Origin| o.is_guess()) - printed;
    let all = portrait.numbers.len();
    say!(
        "\n{guesses} of {all} numbers are guesses, {printed} are of a data sheet or a tyre size; {} says how to \
         measure each",
        path.display()
    );
}

/// A conversation.
struct Interview<'a> {
    input: &'a mut dyn BufRead,
    output: &'a mut dyn Write,
}

impl Interview<'_> {
    /// One answer; `None` at the end of the input.
    fn line(&mut self, question: &str) -> std::io::Result<Option<String>> {
        write!(self.output, "{question}: ")?;
        self.output.flush()?;
        let mut line = String::new();
        let read = self.input.read_line(&mut line)?;
        Ok((read > 0).then(|| line.trim().to_owned()))
    }

    /// Asks until an answer is good or empty.
    fn until<T, E: std::fmt::Display>(
        &mut self,
        question: &str,
        good: impl Fn(&str) -> Result<T, E>,
    ) -> std::io::Result<Option<T>> {
        loop {
            let Some(answer) = self.line(question)?.filter(|a| !a.is_empty()) else {
                return Ok(None);
            };
            match good(&answer) {
                Ok(answer) => return Ok(Some(answer)),
                Err(why) => writeln!(self.output, "  {why}")?,
            }
        }
    }

    /// Asks for all that is not known yet.
    fn about(
        &mut self,
        name: &mut Option<String>,
        owner: &mut Owner,
        catalogue: &'static Catalogue,
    ) -> std::io::Result<()> {
        let number = |text: &str| {
            let number = text.replace(',', ".").parse::<f64>().ok().filter(|x| x.is_finite());
            number.ok_or_else(|| format!("`{text}` is not a number"))
        };
        if name.is_none() {
            *name = self.until("Name of the bike, as in the logs (bike_id)", |a| {
                bad_name(a).map_or(Ok(a.to_owned()), Err)
            })?;
        }
        if owner.class.is_none() && owner.model.is_none() {
            for class in &catalogue.classes {
                writeln!(self.output, "  {:10} {}", class.name, class.description)?;
            }
            let answer = self.until("Make and model, or a class", |a| {
                match (catalogue.model(a), catalogue.class(a)) {
                    (Some(model), _) => Ok((Some(model.name.clone()), None)),
                    (None, Ok(class)) => Ok((None, Some(class.name.clone()))),
                    (None, Err(_)) => Err(format!("`{a}` is not in the catalogue: give its class")),
                }
            })?;
            (owner.model, owner.class) = answer.unwrap_or((None, None));
        }
        let model = owner.model.as_deref().and_then(|m| catalogue.model(m));
        let class = owner.class.as_deref().and_then(|c| catalogue.class(c).ok());
        let usual = match (model, class) {
            (Some(m), _) => [m.front.as_str(), m.rear.as_str()],
            (None, Some(c)) => [c.front.as_str(), c.rear.as_str()],
            (None, None) => [""; 2],
        };
        for (k, axle) in Axle::BOTH.into_iter().enumerate() {
            if owner.sizes[k].is_some() {
                continue;
            }
            let usual = usual[k];
            let question =
                format!("{} tyre, as printed on it (empty: unknown, {usual})", axle.name());
            let size = self.until(&question, TyreSize::parse)?;
            owner.sizes[k] = size.map(|s| s.printed);
        }
        if owner.scales.is_none() {
            let question = "Loads of front and rear wheel on scales, rider seated, kg, as 125,135 (empty: not weighed)";
            owner.scales = self.until(question, list::<2>)?;
        }
        if owner.weight.is_none() && owner.scales.is_none() {
            let question = "Weight of motorcycle and rider in gear, kg (empty: unknown)";
            owner.weight = self.until(question, number)?;
        }
        if owner.scales.is_some() && owner.lifted.is_none() {
            let question =
                "Rear axle lifted by m, front load then kg, as 0.35,140 (empty: not lifted)";
            owner.lifted = self.until(question, list::<2>)?;
        }
        let schema = schema();
        let mut more = owner.clone();
        loop {
            let question =
                "Another number that you measured, as wheelbase=1.43 (empty: write the file)";
            let Some(text) = self.line(question)?.filter(|a| !a.is_empty()) else { break };
            let before = more.clone();
            let fits = |owner: &Owner| owner.portrait(catalogue).map(drop);
            let set = more.set(&text, schema);
            // what does not fit is said now, and not kept
            let fitted = set.and_then(|()| fits(&before).map_or(Ok(()), |()| fits(&more)));
            if let Err(why) = fitted {
                writeln!(self.output, "  {why}")?;
                more = before;
            }
        }
        *owner = more;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn talk(answers: &str) -> (Option<String>, Owner, String) {
        let (mut name, mut owner) = (None, Owner::default());
        let mut said = Vec::new();
        let mut asked = Interview { input: &mut answers.as_bytes(), output: &mut said };
        asked.about(&mut name, &mut owner, Catalogue::builtin()).expect("a conversation");
        (name, owner, String::from_utf8(said).expect("UTF-8"))
    }

    #[test]
    fn a_conversation_asks_again_what_it_does_not_understand() {
        let (name, owner, said) = talk(
            "my bike\nmine\ncruiser\nnaked\nwide\n120/70ZR17\n180/55ZR17\n\n260\nwheelbase=14\nwheelbase=1.44\n\n",
        );
        assert_eq!(name.as_deref(), Some("mine"));
        assert_eq!(owner.class.as_deref(), Some("naked"));
        assert_eq!(owner.sizes[0].as_deref(), Some("120/70ZR17"));
        assert_eq!(owner.weight, Some(260.0));
        assert_eq!(owner.measured["wheelbase"].value, 1.44);
        for part in
            ["cannot be a bike id", "not in the catalogue", "not a tyre size", "not between"]
        {
            assert!(said.contains(part), "{part}: {said}");
        }
    }

    #[test]
    fn a_conversation_does_not_keep_a_second_value_of_a_number() {
        let (_, owner, said) = talk("mine\nnaked\n\n\n100,170\n\nmass=300\nmass=270+-1\n\n");
        assert!(said.contains("`mass` has two values: 270") && said.contains("300"), "{said}");
        assert_eq!(owner.measured["mass"].value, 270.0);
    }

    #[test]
    fn an_option_that_is_given_as_a_key_is_named() {
        let says = option_of("swung_front=5.1,0.2,1.3");
        let want = "`swung_front` is an option of its own: --swung-front 5.1,0.2,1.3";
        assert_eq!(says.as_deref(), Some(want));
        assert!(option_of("class = naked").is_some_and(|s| s.ends_with("--class naked")));
        assert_eq!(option_of("clas=naked"), None);
    }

    #[test]
    fn a_conversation_that_ends_early_leaves_the_rest_unknown() {
        let (name, owner, _) = talk("mine\nMT-07\n");
        assert_eq!((name.as_deref(), owner.model.as_deref()), (Some("mine"), Some("Yamaha MT-07")));
        assert!(owner.weight.is_none() && owner.sizes[1].is_none());
    }

    #[test]
    fn lists_have_their_length() {
        assert_eq!(list::<2>("125, 135"), Ok([125.0, 135.0]));
        for text in ["125", "125,135,1", "a,b", "125,", "inf,1"] {
            assert!(list::<2>(text).is_err(), "{text}");
        }
        assert_eq!(kilograms(" 270.5 "), Ok(270.5));
        for text in ["270,5", "270 kg", "inf", ""] {
            let e = kilograms(text).expect_err(text);
            assert!(e.contains("such as 270.5"), "{text}: {e}");
        }
    }
}
