//! `sparkpath verify`: certifies a path file, whoever made it.

use std::path::Path;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::{Answer, Session, VerifyArguments};
use crate::workspaces::blisk::export::VERIFY;
use crate::workspaces::blisk::report::verify::{VerifiedFile, VerifyReport};
use feed::certificate::Certificate;
use feed::machine::TravelLimits;
use feed::path::FeedPath;
use feed::pose::Axis;
use feed::verify::{Verifier, VerifyError, VerifyOptions};
use files::ExportFolder;
use geometry::mesh::Mesh;
use import::{Reading, Units};
use nc::path_csv::read_path_csv;
use wheel::channel::{Channel, Surface};
use wheel::error::BliskError;
use wheel::find_channel::find_channel;
use wheel::options::{AxisChoice, AxisLine, BliskOptions};
use wheel::surface_finder::SurfaceFinder;

/// Said where a path does not hold for the electrode as it is given, but does for one that stands in the path's frame.
const IN_W: &str = " The electrode's file is in W, the frame of the path, but has to be in the coordinates of the \
    blisk's mesh: export it with [export] frame = \"mesh\".";

/// What is verified.
struct Inputs {
    blisk: Mesh,
    obstacles: Option<Arc<Mesh>>,
    electrode: Mesh,
    path: FeedPath,
    files: Vec<VerifiedFile>,
}

/// Verifies the path of `arguments`.
pub(super) fn verify(arguments: &VerifyArguments, session: &Session) -> anyhow::Result<Answer> {
    let options = options(arguments)?;
    let mut inputs = read(arguments, session)?;
    let found = channel_of(&inputs.blisk, &inputs.path, session)?;
    let found = found.map(|channel| Channel { obstacles: inputs.obstacles.clone(), ..channel });
    // Of a sector the whole wheel is in the way, whichever channel of it was found.
    if let Some(whole) = found.as_ref().and_then(|channel| channel.whole.as_deref()) {
        inputs.blisk = whole.clone();
    }
    if let Some(obstacles) = &inputs.obstacles {
        inputs.blisk.append(obstacles);
    }
    let channel = found.filter(|channel| is_of(channel, &inputs.path));
    if let Some(folder) = &arguments.out {
        // An older verdict must not outlive a failure of this one.
        for name in ["verify.json", "verify.html"] {
            let _ = std::fs::remove_file(folder.join(name));
        }
    }
    let in_w = inputs.electrode.in_frame(&inputs.path.frame);
    let finder = channel.as_ref().map(|c| SurfaceFinder::new(c.clone().into())).transpose()?;
    let surface_of = |p| finder.as_ref().map_or(Surface::Elsewhere, |f| f.surface_of(p));
    let certified = |electrode: &Mesh| -> anyhow::Result<(Verifier, Certificate)> {
        let verifier = verifier(&inputs, electrode, travel(arguments), session)?;
        let certificate = verifier.verify(&inputs.path, &surface_of, &options, &session.task)?;
        Ok((verifier, certificate))
    };
    let (verifier, certificate) = certified(&in_w)?;
    let surface_name = |surface| channel.as_ref().map_or("blisk", |channel| channel.surface_name(surface));
    let surface = surface_name(certificate.least().surface);
    let mut report = VerifyReport::new(&inputs.path, &certificate, surface, inputs.files.clone());
    // A file that is already in W is a mistake easily made, and looks like a collision.
    if !report.verified && certified(&inputs.electrode)?.1.holds() {
        report.sentence += IN_W;
    }
    if let Some(errors) = arguments.setting.as_ref().filter(|_| report.verified) {
        let least_mm = arguments.gap - arguments.accuracy;
        let room = verifier.setting_room(&inputs.path, errors, least_mm, &surface_of, &session.task)?;
        report = report.with_setting(&room, surface_name);
    }
    let json = report.json()?;
    if let Some(folder) = &arguments.out {
        write(folder, &report, &json)?;
    }
    super::terminal::finish();
    say!("{}", if session.json { json.trim_end() } else { &report.sentence });
    if let Some(setting) = report.setting.as_ref().filter(|_| !session.json) {
        say!("{}", setting.sentence);
    }
    let bears = report.setting.as_ref().is_none_or(|setting| setting.holds);
    Ok(if report.verified && bears { Answer::Yes } else { Answer::No })
}

fn options(arguments: &VerifyArguments) -> anyhow::Result<VerifyOptions> {
    anyhow::ensure!(
        arguments.gap > 0.0 && arguments.gap <= 100.0,
        "--gap {}: must be a length in mm greater than 0 and at most 100",
        arguments.gap
    );
    let options = VerifyOptions { tolerance_mm: arguments.tolerance, ..Default::default() };
    options.validate(arguments.gap).map_err(|error| match error {
        VerifyError::Tolerance { tolerance_mm, spark_gap_mm } => anyhow::anyhow!(
            "--tolerance {tolerance_mm}: must be 0 or more and less than half the gap of {spark_gap_mm} mm"
        ),
        other => other.into(),
    })?;
    anyhow::ensure!(
        (0.0..arguments.gap).contains(&arguments.accuracy) || arguments.setting.is_none(),
        "--accuracy {}: must be 0 or more and less than the gap of {} mm",
        arguments.accuracy,
        arguments.gap
    );
    Ok(options)
}

fn read(arguments: &VerifyArguments, session: &Session) -> anyhow::Result<Inputs> {
    let name = arguments.path.display();
    let text = std::fs::read_to_string(&arguments.path)
        .map_err(|e| anyhow::anyhow!("{name}: cannot be read ({e}); check the path"))?;
    let path = read_path_csv(&text).map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let (solids, obstacles) = (arguments.solids.clone(), arguments.obstacles.clone());
    let reading = Reading { units: arguments.units, solids, obstacles, ..Reading::default() };
    let blisk = session.import(&arguments.blisk, &reading)?;
    let electrode = session.import(&arguments.electrode, &Units::Mm.into())?;
    super::require_closed(&arguments.blisk, &blisk.report)?;
    super::require_closed(&arguments.electrode, &electrode.report)?;
    let path_sha256 = Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    let file = |role, path: &Path, sha256: String| VerifiedFile { role, path: path.display().to_string(), sha256 };
    Ok(Inputs {
        files: vec![
            file("blisk", &arguments.blisk, blisk.sha256),
            file("electrode", &arguments.electrode, electrode.sha256),
            file("path", &arguments.path, path_sha256),
        ],
        blisk: blisk.mesh,
        obstacles: blisk.obstacles.map(Arc::new),
        electrode: electrode.mesh,
        path: FeedPath { spark_gap: arguments.gap, ..path },
    })
}

/// The limits of the axes that were given; none if none was.
fn travel(arguments: &VerifyArguments) -> Option<TravelLimits> {
    let with = |limits: TravelLimits, &(axis, travel): &(Axis, [f64; 2])| {
        limits.with(axis, if axis.is_rotary() { travel.map(f64::to_radians) } else { travel })
    };
    (!arguments.travel.is_empty()).then(|| arguments.travel.iter().fold(TravelLimits::UNLIMITED, with))
}

fn verifier(
    inputs: &Inputs,
    electrode_in_w: &Mesh,
    travel: Option<TravelLimits>,
    session: &Session,
) -> anyhow::Result<Verifier> {
    let Inputs { blisk, path, .. } = inputs;
    let verifier =
        Verifier::new(&blisk.in_frame(&path.frame), electrode_in_w, path.reference_point, &session.task.cancel)?;
    Ok(match travel {
        Some(travel) => verifier.within(travel),
        None => verifier,
    })
}

/// A channel of the blisk, about the axis of the path if none is found by itself: none is no obstacle to verifying it.
///
/// # Errors
/// If the mesh is a sector that no whole wheel can be made of: the neighbours of the sector would not be looked at.
fn channel_of(blisk: &Mesh, path: &FeedPath, session: &Session) -> anyhow::Result<Option<Channel>> {
    let line = AxisLine { direction: path.frame.x.into(), point: path.frame.origin.into() };
    let about_path = BliskOptions { axis: AxisChoice::Line(line), ..BliskOptions::default() };
    let find = |options: &BliskOptions| find_channel(blisk, options, &session.task);
    match find(&BliskOptions::default()).or_else(|_| find(&about_path)) {
        Ok(channel) => Ok(Some(channel)),
        Err(BliskError::Sector(error)) => {
            anyhow::bail!("{error}; a path is verified against the whole wheel: give the mesh of that")
        }
        Err(_) => Ok(None),
    }
}

/// Whether the path's frame is that of the channel, which then names its surfaces.
fn is_of(channel: &Channel, path: &FeedPath) -> bool {
    (channel.frame.z - path.frame.z).length() < 1e-4 && (channel.frame.origin - path.frame.origin).length() < 1e-3
}

/// Writes under names of its own: a plan's `report.json` in the same folder is another thing.
fn write(folder: &Path, report: &VerifyReport, json: &str) -> anyhow::Result<()> {
    let html = report.html()?;
    let files = [("verify.json", json.as_bytes()), ("verify.html", html.as_bytes())];
    ExportFolder::write_all(folder, VERIFY, &files)?;
    Ok(())
}
