//! The named views of engineering drawing.

use glam::{DMat3, DQuat, DVec3};

/// A standard direction of view. The front of a part faces -Y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StandardView {
    /// From -Y.
    Front,
    /// From +Y.
    Back,
    /// From -X.
    Left,
    /// From +X.
    Right,
    /// From +Z, +Y to the top of the picture.
    Top,
    /// From -Z, -Y to the top of the picture.
    Bottom,
    /// From the front, the right and above, all three axes equally foreshortened.
    Isometric,
}

impl StandardView {
    /// Every view, in the order of a menu.
    pub const ALL: [Self; 7] =
        [Self::Front, Self::Back, Self::Left, Self::Right, Self::Top, Self::Bottom, Self::Isometric];

    /// Name in the window and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
            Self::Left => "left",
            Self::Right => "right",
            Self::Top => "top",
            Self::Bottom => "bottom",
            Self::Isometric => "isometric",
        }
    }

    /// The view of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|v| v.name().eq_ignore_ascii_case(name))
    }

    /// The orientation of a [`Camera`](super::camera::Camera) with this view.
    pub fn orientation(self) -> DQuat {
        let (towards_viewer, up) = match self {
            Self::Front => (DVec3::NEG_Y, DVec3::Z),
            Self::Back => (DVec3::Y, DVec3::Z),
            Self::Left => (DVec3::NEG_X, DVec3::Z),
            Self::Right => (DVec3::X, DVec3::Z),
            Self::Top => (DVec3::Z, DVec3::Y),
            Self::Bottom => (DVec3::NEG_Z, DVec3::NEG_Y),
            Self::Isometric => (DVec3::new(1.0, -1.0, 1.0), DVec3::Z),
        };
        looking(towards_viewer, up)
    }
}

/// The orientation of a camera that sees the scene from the direction `towards_viewer`, with `up` upwards in
/// the picture as far as possible.
pub fn looking(towards_viewer: DVec3, up: DVec3) -> DQuat {
    let z = towards_viewer.normalize_or(DVec3::Z);
    let x = up.cross(z).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;

    #[test]
    fn the_views_show_the_axes_where_drawing_practice_has_them() {
        let right_and_up = |view: StandardView| {
            let camera = Camera { orientation: view.orientation(), ..Camera::default() };
            [camera.right(), camera.up()]
        };
        for (view, expected) in [
            (StandardView::Front, [DVec3::X, DVec3::Z]),
            (StandardView::Back, [DVec3::NEG_X, DVec3::Z]),
            (StandardView::Right, [DVec3::Y, DVec3::Z]),
            (StandardView::Left, [DVec3::NEG_Y, DVec3::Z]),
            (StandardView::Top, [DVec3::X, DVec3::Y]),
            (StandardView::Bottom, [DVec3::X, DVec3::NEG_Y]),
        ] {
            for (found, wanted) in right_and_up(view).into_iter().zip(expected) {
                assert!((found - wanted).length() < 1e-12, "{view:?}");
            }
            assert_eq!(StandardView::from_name(&view.name().to_uppercase()), Some(view));
        }
        let [right, up] = right_and_up(StandardView::Isometric);
        assert!(right.z.abs() < 1e-12 && up.z > 0.8 && right.x > 0.0 && right.y > 0.0);
    }
}
