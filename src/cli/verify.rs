//! `sparkpath verify`: certifies a path file, whoever made it.

use serde::Serialize;

use super::{Answer, Session, VerifyArguments};
use crate::blisk::channel::{Channel, Surface};
use crate::blisk::find_channel::find_channel;
use crate::blisk::options::BliskOptions;
use crate::blisk::surface_finder::SurfaceFinder;
use crate::export::files::write_atomically;
use crate::export::path_csv::read_path_csv;
use crate::feed::certificate::Certificate;
use crate::feed::path::FeedPath;
use crate::feed::verify::{Verifier, VerifyOptions};
use crate::geometry::mesh::Mesh;
use crate::mesh_io::Units;

/// `report.json` of a verification.
#[derive(Serialize)]
struct VerifyReport<'a> {
    schema: u32,
    program_version: &'static str,
    inputs: [Input<'a>; 2],
    path: String,
    verified: bool,
    required_clearance_mm: f64,
    tolerance_mm: f64,
    certified_clearance_mm: f64,
    least_clearance_mm: f64,
    least_clearance_at: Place<'a>,
    starts_outside_and_ends_at_zero: bool,
    rows: usize,
    sentence: String,
}

#[derive(Serialize)]
struct Input<'a> {
    role: &'static str,
    path: String,
    sha256: &'a str,
}

#[derive(Serialize)]
struct Place<'a> {
    row: f64,
    s_mm: f64,
    on_electrode: [f64; 3],
    on_blisk: [f64; 3],
    surface: &'a str,
}

/// Verifies the path of `arguments`.
pub(super) fn verify(arguments: &VerifyArguments, session: &Session) -> anyhow::Result<Answer> {
    anyhow::ensure!(
        arguments.gap > 0.0 && arguments.gap <= 100.0,
        "--gap {}: must be a length in mm greater than 0 and at most 100",
        arguments.gap
    );
    let text = std::fs::read_to_string(&arguments.path)
        .map_err(|e| anyhow::anyhow!("{}: cannot be read ({e}); check the path", arguments.path.display()))?;
    let path = read_path_csv(&text).map_err(|e| anyhow::anyhow!("{}: {e}", arguments.path.display()))?;
    let path = FeedPath { spark_gap: arguments.gap, ..path };
    let blisk = session.import(&arguments.blisk, arguments.units)?;
    let electrode = session.import(&arguments.electrode, Units::Mm)?;
    super::require_closed(&arguments.blisk, &blisk)?;
    super::require_closed(&arguments.electrode, &electrode)?;
    let channel = channel_of(&blisk.mesh, &path, session);
    let options = VerifyOptions { tolerance_mm: arguments.tolerance, ..Default::default() };
    options.validate()?;
    anyhow::ensure!(
        arguments.tolerance < 0.5 * arguments.gap,
        "--tolerance {}: must be less than half the gap of {} mm",
        arguments.tolerance,
        arguments.gap
    );
    if let Some(folder) = &arguments.out {
        // An older verdict must not outlive a failure of this one.
        let _ = std::fs::remove_file(folder.join("report.json"));
    }
    let certificate = certify(&blisk.mesh, &electrode.mesh, &path, channel.as_ref(), &options, session)?;
    let surface = match &channel {
        Some(channel) => channel.surface_name(certificate.least().surface),
        None => "blisk",
    };
    let report = VerifyReport {
        schema: 1,
        program_version: env!("CARGO_PKG_VERSION"),
        inputs: [
            Input { role: "blisk", path: arguments.blisk.display().to_string(), sha256: &blisk.sha256 },
            Input { role: "electrode", path: arguments.electrode.display().to_string(), sha256: &electrode.sha256 },
        ],
        path: arguments.path.display().to_string(),
        verified: certificate.holds(),
        required_clearance_mm: certificate.required(),
        tolerance_mm: certificate.tolerance(),
        certified_clearance_mm: certificate.certified(),
        least_clearance_mm: certificate.least().distance,
        least_clearance_at: Place {
            row: certificate.least().row,
            s_mm: certificate.least().s,
            on_electrode: certificate.least().on_electrode.to_array(),
            on_blisk: certificate.least().on_blisk.to_array(),
            surface,
        },
        starts_outside_and_ends_at_zero: certificate.ends_right(),
        rows: path.rows.len(),
        sentence: sentence(&certificate, surface),
    };
    let json = serde_json::to_string_pretty(&report)?;
    if let Some(folder) = &arguments.out {
        std::fs::create_dir_all(folder)
            .map_err(|e| anyhow::anyhow!("{}: the folder cannot be made ({e}); give another", folder.display()))?;
        write_atomically(&folder.join("report.json"), format!("{json}\n").as_bytes())?;
    }
    super::terminal::finish();
    say!("{}", if session.json { &json } else { &report.sentence });
    Ok(if report.verified { Answer::Yes } else { Answer::No })
}

fn sentence(c: &Certificate, surface: &str) -> String {
    let verdict = if c.holds() { "verified" } else { "NOT verified" };
    let ends = if c.ends_right() { "" } else { "; the path does not lead from outside the blisk to the final pose" };
    format!(
        "{verdict}: certified clearance {:.5} mm, least met {:.5} mm, required {:.5} mm less {:.5} mm; least against the \
         {surface} at row {:.2}, {:.3} mm before the final pose{ends}",
        c.certified(),
        c.least().distance,
        c.required(),
        c.tolerance(),
        c.least().row,
        c.least().s
    )
}

fn certify(
    blisk: &Mesh,
    electrode: &Mesh,
    path: &FeedPath,
    channel: Option<&Channel>,
    options: &VerifyOptions,
    session: &Session,
) -> anyhow::Result<Certificate> {
    let verifier = Verifier::new(&blisk.in_frame(&path.frame), &electrode.in_frame(&path.frame), path.reference_point)?;
    let finder = channel.map(SurfaceFinder::new).transpose()?;
    let surface_of = |p| finder.as_ref().map_or(Surface::Elsewhere, |f| f.surface_of(p));
    Ok(verifier.verify(path, &surface_of, options, &session.progress, &session.cancel)?)
}

/// The channel that the path's frame belongs to, for naming surfaces: none if the blisk's channels are not found
/// or the path was made in another frame, which is no obstacle to verifying it.
fn channel_of(blisk: &Mesh, path: &FeedPath, session: &Session) -> Option<Channel> {
    let channel = find_channel(blisk, &BliskOptions::default(), &session.progress, &session.cancel).ok()?;
    let same =
        (channel.frame.z - path.frame.z).length() < 1e-4 && (channel.frame.origin - path.frame.origin).length() < 1e-3;
    same.then_some(channel)
}
