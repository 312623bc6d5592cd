//! Settings of the NC programs of flank paths, and the posts for them.

use serde::{Deserialize, Serialize};

use crate::block_feed::LEAST_BLOCK_MINUTES;
use crate::lines::NcError;
use crate::post::{self, FeedMode, Post, PostError};
use flank::machine::joint_feed::{Contact, Feeds};
use flank::machine::linearise::{Interpolation, LinearisationParams};

/// Name and text of the post that comes with the program.
pub const BUILT_IN_POST: (&str, &str) = ("milling", include_str!("../../../../assets/posts/milling.toml"));

/// The posts for milling that come with the program: name and text.
pub const BUILT_IN_POSTS: &[(&str, &str)] =
    &[BUILT_IN_POST, ("milling-tcp", include_str!("../../../../assets/posts/milling-tcp.toml"))];

/// Meaning of X Y Z in a program.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TipControl {
    /// Positions of the axes.
    #[default]
    Off,
    /// The tip on the workpiece in the machine's directions, with the rotary axes (G43.4 on many controls); the post
    /// must have the word.
    Angles,
    /// Tip on the workpiece with the tool's direction as I J K (G43.5 on many controls); the post must have the word.
    /// The control chooses the rotary axes.
    Vector,
}

impl TipControl {
    /// All kinds of control.
    pub const ALL: [Self; 3] = [Self::Off, Self::Angles, Self::Vector];

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Angles => "angles",
            Self::Vector => "vector",
        }
    }

    /// Interpolation of the control; [`LinearisationParams::interpolation`] must be this.
    pub fn interpolation(self) -> Interpolation {
        match self {
            Self::Off => Interpolation::Joints,
            Self::Angles | Self::Vector => Interpolation::Tip,
        }
    }
}

/// Speeds and words of a program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlankNcSettings {
    /// Feed of the cut along the flank, and of the moves onto it and off it (mm/min).
    pub feed_mm_per_min: f64,
    /// Feed of the other moves of approach and retraction (mm/min).
    pub lead_mm_per_min: f64,
    /// Spindle speed, clockwise (1/min).
    pub spindle_rpm: f64,
    /// Meaning of X Y Z in a program.
    pub tip_control: TipControl,
    /// Number of the tool's length offset, for a control that follows the tip.
    pub tool_number: u32,
}

impl Default for FlankNcSettings {
    fn default() -> Self {
        let tip_control = TipControl::Off;
        Self { feed_mm_per_min: 500.0, lead_mm_per_min: 2000.0, spindle_rpm: 12000.0, tip_control, tool_number: 1 }
    }
}

impl FlankNcSettings {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`NcError::Setting`] naming the setting.
    pub fn validate(&self) -> Result<(), NcError> {
        let settings = [
            ("feed_mm_per_min", self.feed_mm_per_min, 0.001, 1e5, "0.001 to 100000 mm/min"),
            ("lead_mm_per_min", self.lead_mm_per_min, 0.001, 1e5, "0.001 to 100000 mm/min"),
            ("spindle_rpm", self.spindle_rpm, 1.0, 1e6, "1 to 1000000 1/min"),
            ("tool_number", f64::from(self.tool_number), 0.0, 99999.0, "0 to 99999"),
        ];
        let wrong = settings.into_iter().find(|(_, value, low, high, _)| !(*low..=*high).contains(value));
        wrong.map_or(Ok(()), |(name, value, _, _, range)| Err(NcError::Setting { name, value, range }))
    }

    /// The feeds of a program in the words of `post`, along positions that were made with `params`, of flutes that
    /// touch as `contact` says.
    pub fn feeds(&self, params: &LinearisationParams, post: &Post, contact: Option<Contact>) -> Feeds {
        let is_timed = post.feed.mode != FeedMode::PerMinute;
        Feeds {
            cut_mm_min: self.feed_mm_per_min,
            lead_mm_min: self.lead_mm_per_min,
            reach_mm: params.reach_mm,
            least_minutes: if is_timed { LEAST_BLOCK_MINUTES } else { 0.0 },
            interpolation: params.interpolation,
            contact,
        }
    }
}

/// A built-in post for milling, or any other that [`Post::named`] knows.
///
/// # Errors
/// [`PostError`].
pub fn milling_post(name: &str) -> Result<Post, PostError> {
    if let Some((_, text)) = BUILT_IN_POSTS.iter().find(|(built_in, _)| *built_in == name) {
        return Post::from_toml(text, name);
    }
    Post::named(name).map_err(|error| match error {
        PostError::Unknown { name, .. } => PostError::Unknown { name, known: milling_posts() },
        other => other,
    })
}

/// Names of the built-in posts, those for milling first.
pub fn milling_posts() -> Vec<&'static str> {
    BUILT_IN_POSTS.iter().chain(post::BUILT_IN).map(|(name, _)| *name).collect()
}
