//! `flaneur eval`: renderings against photographs that were held out.

mod contender;
mod session;
mod target;

use std::collections::BTreeSet;
use std::num::NonZero;
use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use flaneur_scene::ImageId;

use super::Context;
use crate::atomic_file;
use crate::evaluation::{Choice, Described, Gallery, METHODS, Method, Report, Split, page};
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::names::{Names, Pattern};
use crate::output;
use session::Session;
use target::Target;

/// SOURCE comes first, because --hold-out and --only take as many names as follow them.
const USAGE: &str = "\
flaneur eval <SOURCE> <--sources every:N|--hold-out …|--truth …>
                    --report <FILE> [OPTIONS]";

const EXAMPLES: &str = "\
Examples:
  flaneur eval scenes/karlsruhe --sources every:2 --only '02_*' \\
    --report every2.json
  flaneur eval scenes/paris --hold-out 490 495/301 \\
    --report two.json --html two.html
  flaneur eval scenes/street --truth street/truth \\
    --methods nearest,hybrid --report truth.json

Names are ids, panoramas, files of photographs, or globs over them; `flaneur info SOURCE --json` \
lists the ids. Each face of a sphere is a photograph; every:N keeps a sphere, like any rig, or \
holds it out as a whole. Methods that change more than how a frame is drawn have a renderer for \
themselves, one after another, each within --gpu-memory, and fetch the scene anew: name fewer \
--methods where time is short.

Definitions: sRGB in [0, 1], the whole frame, a figure a view, then the mean over the views. SSIM \
in windows of 7x7 pixels of equal weight with sample covariance (scikit-image's default). \
Coverage is the share of the pixels showing geometry that a source colours, as in the reports of \
`flaneur render`; none for a source shown unwarped. Inferred is the share of all pixels that \
sources colour at an inferred depth, where there is no geometry; unseen the share of all pixels \
that no source colours either way. Each figure is given again over what the photograph's mask \
shows (…_unmasked), and over what of that is not unseen (…_covered).";

/// Arguments of `flaneur eval`.
#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = USAGE)]
#[command(group = ArgGroup::new("what").required(true).args(["hold_out", "sources", "truth"]))]
pub(crate) struct EvalArguments {
    /// Scene: a store's folder or URL with the scene's name at its end, or
    /// http://host:port/scene; the name may be left out where there is only one
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Hold out these photographs: ids, panoramas, or globs over either
    #[arg(long, value_name = "IMAGE_ID", num_args = 1.., value_parser = Pattern::parse)]
    hold_out: Vec<Pattern>,
    /// In the order of their names, keep the first panorama and every N-th after it as sources,
    /// and hold out all others
    #[arg(long, value_name = "every:N")]
    sources: Option<Every>,
    /// Hold out nothing: render the views of this file and compare them with the pictures that it
    /// names, beside it. A folder stands for its views.json
    #[arg(long, value_name = "VIEWS.json")]
    truth: Option<PathBuf>,
    /// Let only these photographs take part, as sources and as held out
    #[arg(long, value_name = "GLOB", num_args = 1.., value_parser = Pattern::parse)]
    only: Vec<Pattern>,
    /// Methods to compare, separated by commas [default: all]
    #[arg(long, value_name = "METHOD", value_delimiter = ',', value_parser = method_parser())]
    methods: Vec<&'static Method>,
    #[command(flatten)]
    gpu_memory: GpuMemory,
    /// Every score and their means, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: PathBuf,
    /// Tables, plots, and small pictures of the views, as one page
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
}

/// `every:N` with N of at least 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Every(NonZero<usize>);

/// Evaluates, writes the report, prints the means.
pub(crate) async fn run(arguments: EvalArguments, context: &Context) -> Result<(), Exit> {
    for file in [Some(&arguments.report), arguments.html.as_ref()].into_iter().flatten() {
        atomic_file::check_folder(file)?;
    }
    let methods: Vec<&'static Method> = METHODS
        .iter()
        .filter(|method| {
            arguments.methods.is_empty() || arguments.methods.iter().any(|m| m.name == method.name)
        })
        .collect();
    let evaluate = async {
        let count = methods.len();
        let mut session = Session::prepare(&arguments, methods).await?;
        let mut gallery = arguments.html.is_some().then(|| Gallery::new(session.targets(), count));
        let rows = session.run(gallery.as_mut(), context).await?;
        Ok::<_, Exit>((session.report(rows), gallery))
    };
    let (report, gallery) = tokio::select! {
        () = context.cancel.cancelled() => return Err(Exit::Interrupted),
        evaluated = evaluate => evaluated?,
    };
    if let (Some(file), Some(gallery)) = (&arguments.html, &gallery) {
        atomic_file::write(file, page(&report, gallery).as_bytes())?;
    }
    let mut json = serde_json::to_vec_pretty(&report)?;
    json.push(b'\n');
    atomic_file::write(&arguments.report, &json)?;
    output::print(&summary(&report))
}

/// The photographs that may be used, and the views that are rendered from them.
fn chosen(
    arguments: &EvalArguments,
    names: &Names,
) -> Result<(BTreeSet<ImageId>, Vec<Target>), Exit> {
    for pattern in &arguments.only {
        names.check(pattern)?;
    }
    let only = &arguments.only;
    let takes_part =
        |id: &ImageId| only.is_empty() || only.iter().any(|pattern| pattern.matches(id));
    let taking_part = names.photographs().keys().filter(|id| takes_part(id)).cloned();
    if let Some(truth) = &arguments.truth {
        return Ok((taking_part.collect(), target::truth(truth)?));
    }
    for pattern in &arguments.hold_out {
        names.check_among(pattern, takes_part)?;
    }
    let held_out = |id: &ImageId| arguments.hold_out.iter().any(|pattern| pattern.matches(id));
    let choice = match arguments.sources {
        Some(Every(n)) => Choice::Every(n),
        None => Choice::Where(&held_out),
    };
    let split = Split::new(taking_part, &choice).map_err(Exit::bad_input)?;
    let held_out = names.photographs().iter().filter(|(id, _)| split.targets.contains(*id));
    let targets = held_out.map(|(id, photograph)| Target::held_out(id, photograph)).collect();
    Ok((split.sources, targets))
}

impl EvalArguments {
    /// What is held out, as it was asked for.
    fn described(&self) -> String {
        match (&self.truth, self.sources) {
            (Some(truth), _) => format!("--truth {}", truth.display()),
            (None, Some(Every(n))) => format!("--sources every:{n}"),
            (None, None) => {
                let names: Vec<_> = self.hold_out.iter().map(Pattern::to_string).collect();
                format!("--hold-out {}", names.join(" "))
            }
        }
    }
}

/// The means as a table.
fn summary(report: &Report) -> String {
    let mut lines = vec![format!(
        "{:28}{:>8}{:>8}{:>8}{:>10}{:>10}{:>10}",
        "", "PSNR dB", "SSIM", "RMSE", "coverage", "inferred", "unseen"
    )];
    lines.extend(report.mean.iter().map(|(method, score)| {
        format!(
            "{method:28}{:8.2}{:8.3}{:8.4}{:>10}{:>10}{:>10}",
            score.psnr_db,
            score.ssim,
            score.rmse,
            percent(score.coverage),
            percent(score.inferred),
            percent(score.unseen)
        )
    }));
    let Described { targets, sources, .. } = report.settings;
    lines.push(format!("mean over {targets} views, rendered from {sources} photographs\n"));
    lines.join("\n")
}

/// A share as per cent; a dash where there is none.
fn percent(share: f64) -> String {
    if share.is_nan() { "-".to_owned() } else { format!("{:.1}%", 100.0 * share) }
}

fn method_parser() -> impl TypedValueParser<Value = &'static Method> {
    let values = METHODS.iter().map(|method| PossibleValue::new(method.name).help(method.about));
    PossibleValuesParser::new(values.collect::<Vec<_>>())
        .try_map(|name| Method::named(&name).ok_or("no such method"))
}

impl FromStr for Every {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let n = text.strip_prefix("every:").and_then(|n| n.parse::<usize>().ok());
        let n = n.ok_or_else(|| format!("{text:?} is not every:N, as in every:2"))?;
        match NonZero::new(n) {
            Some(n) if n.get() > 1 => Ok(Self(n)),
            Some(_) => Err("every:1 keeps every photograph: nothing is held out".to_owned()),
            None => Err("every:0 keeps no photograph; the least is every:2".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_nth_is_written_every_n() {
        assert_eq!("every:8".parse(), Ok(Every(NonZero::new(8).expect("not zero"))));
        for (wrong, problem) in
            [("every:0", "no photograph"), ("every:1", "nothing is held out"), ("2", "every:2")]
        {
            let error = wrong.parse::<Every>().expect_err(wrong);
            assert!(error.contains(problem), "{error}");
        }
        assert!("every:-1".parse::<Every>().is_err() && "every:".parse::<Every>().is_err());
    }
}
