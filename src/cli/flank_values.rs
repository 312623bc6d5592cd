//! Values of the arguments of `sparkpath flank`, read from words.

use clap::ValueEnum;
use glam::DVec3;

use crate::workspaces::flank::document::{CutDirection, DemonstrationSurface, PathChoice};
use flank::cutter::HolderPart;
use flank::params::OffsetMethod;
use flank::ruled_surface::Side;
use nc::flank_job::CheckKind;
use nc::flank_job::overrides::FlankOverride;
use nc::flank_program::TipControl;

/// See [`CutDirection`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum CutName {
    Climb,
    Conventional,
}

impl From<CutName> for CutDirection {
    fn from(name: CutName) -> Self {
        match name {
            CutName::Climb => Self::Climb,
            CutName::Conventional => Self::Conventional,
        }
    }
}

/// See [`DemonstrationSurface`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum Demo {
    A,
    B,
}

impl From<Demo> for DemonstrationSurface {
    fn from(name: Demo) -> Self {
        match name {
            Demo::A => Self::A,
            Demo::B => Self::B,
        }
    }
}

/// See [`Side`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum SideName {
    Automatic,
    Positive,
    Negative,
}

impl From<SideName> for Side {
    fn from(name: SideName) -> Self {
        match name {
            SideName::Automatic => Self::Automatic,
            SideName::Positive => Self::Positive,
            SideName::Negative => Self::Negative,
        }
    }
}

/// See [`OffsetMethod`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum OffsetName {
    TwoPoint,
    ThreePoint,
}

impl From<OffsetName> for OffsetMethod {
    fn from(name: OffsetName) -> Self {
        match name {
            OffsetName::TwoPoint => Self::TwoPoint,
            OffsetName::ThreePoint => Self::ThreePoint,
        }
    }
}

/// See [`flank::params::Objective`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ObjectiveName {
    Sum,
    Rms,
    Bounded,
}

/// See [`PathChoice`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum PathName {
    Initial,
    Chosen,
    Refined,
}

impl From<PathName> for PathChoice {
    fn from(name: PathName) -> Self {
        match name {
            PathName::Initial => Self::Initial,
            PathName::Chosen => Self::Chosen,
            PathName::Refined => Self::Refined,
        }
    }
}

/// See [`TipControl`].
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum TipName {
    Off,
    Angles,
    Vector,
}

impl From<TipName> for TipControl {
    fn from(name: TipName) -> Self {
        match name {
            TipName::Off => Self::Off,
            TipName::Angles => Self::Angles,
            TipName::Vector => Self::Vector,
        }
    }
}

/// A part of a holder, as `length:radius` or `length:lower radius:upper radius` (mm).
pub(super) fn holder_part(text: &str) -> Result<HolderPart, String> {
    let wrong = || "expected length:radius or length:lower radius:upper radius in mm, as in 20:10:15".to_owned();
    let numbers: Result<Vec<f64>, _> = text.split(':').map(|n| n.trim().parse::<f64>()).collect();
    match numbers.map_err(|_| wrong())?[..] {
        [length_mm, radius] => Ok(HolderPart { length_mm, lower_radius_mm: radius, upper_radius_mm: radius }),
        [length_mm, lower_radius_mm, upper_radius_mm] => Ok(HolderPart { length_mm, lower_radius_mm, upper_radius_mm }),
        _ => Err(wrong()),
    }
}

/// The number of a flank of a mesh, from 1.
pub(super) fn flank_number(text: &str) -> Result<u32, String> {
    match text.trim().parse::<u32>() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err("expected one number from 1, as --list has them; faces that go over into each other smoothly are one flank \
                  together there, others are milled one after the other"
            .to_owned()),
    }
}

/// Three finite numbers with commas between.
pub(super) fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse::<f64>()).collect();
    match numbers.unwrap_or_default()[..] {
        [x, y, z] if DVec3::new(x, y, z).is_finite() => Ok(DVec3::new(x, y, z)),
        _ => Err("expected three numbers with commas between, as in 0,0,30".to_owned()),
    }
}

/// A direction: a letter with its sign, or three numbers with commas between.
pub(super) fn direction(text: &str) -> Result<DVec3, String> {
    let (sign, letter) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let found = match letter.to_ascii_lowercase().as_str() {
        "x" => sign * DVec3::X,
        "y" => sign * DVec3::Y,
        "z" => sign * DVec3::Z,
        _ => vector(text)
            .map_err(|_| "expected +x, -x, +y, -y, +z, -z, or three numbers with commas between".to_owned())?,
    };
    // No zero with a sign.
    Ok(found + DVec3::ZERO)
}

/// The name of a check that is let pass, with the greatest figure if one is given.
pub(super) fn check_override(text: &str) -> Result<FlankOverride, String> {
    let given: FlankOverride = text.parse()?;
    let names = CheckKind::ALL.map(CheckKind::name);
    if names.contains(&given.check.as_str()) {
        return Ok(given);
    }
    Err(format!("there is no check {:?}; there are {}", given.check, names.join(", ")))
}

/// Places along u and v, as in `100x50`.
pub(super) fn grid(text: &str) -> Result<[usize; 2], String> {
    let wrong = || "expected the samples along u and v, as in 100x50".to_owned();
    let (u, v) = text.split_once('x').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<usize>().map_err(|_| wrong());
    Ok([number(u)?, number(v)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_holders_and_grids_are_read_or_refused() {
        let part = holder_part("20:10:15").unwrap();
        assert_eq!((part.length_mm, part.lower_radius_mm, part.upper_radius_mm), (20.0, 10.0, 15.0));
        assert_eq!(holder_part("30:3").unwrap().upper_radius_mm, 3.0);
        assert_eq!(check_override("gouge:0.2").unwrap().most, Some(0.2));
        let why = check_override("nonsense").unwrap_err();
        assert!(why.contains("nonsense") && why.contains("ruled, guides, cutter, coverage"), "{why}");
        assert_eq!(flank_number("3"), Ok(3));
        for text in ["0", "3,4", "-1", "a", ""] {
            assert!(flank_number(text).unwrap_err().contains("one number from 1"), "{text}");
        }
        assert_eq!(grid("100x50"), Ok([100, 50]));
        assert_eq!(direction("-Z"), Ok(-DVec3::Z));
        assert_eq!(direction("0,1,-2.5"), Ok(DVec3::new(0.0, 1.0, -2.5)));
        assert!(direction("w").is_err() && direction("1,2").is_err() && direction("nan,0,0").is_err());
        for text in ["", "20", "20:a", "1:2:3:4"] {
            assert!(holder_part(text).is_err(), "{text}");
        }
        for text in ["", "100", "100x", "-1x5", "1x2x3"] {
            assert!(grid(text).is_err(), "{text}");
        }
    }
}
