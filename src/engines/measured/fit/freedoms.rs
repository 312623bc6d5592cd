//! The freedoms of a fit: along and about which axes the points may move.

use geometry::frame::Frame;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use nalgebra::{DMatrix, DVector};

use crate::MeasuredError;

/// Freedom of a rigid body, along or about an axis of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Freedom {
    /// Translation along X (mm).
    X,
    /// Translation along Y (mm).
    Y,
    /// Translation along Z (mm).
    Z,
    /// Rotation about X (rad).
    A,
    /// Rotation about Y (rad).
    B,
    /// Rotation about Z (rad).
    C,
}

impl Freedom {
    /// Every freedom in order.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C];

    /// Letter of the axis.
    pub fn letter(self) -> char {
        ['X', 'Y', 'Z', 'A', 'B', 'C'][self as usize]
    }

    /// Whether the freedom is a rotation, with values in radians.
    pub fn is_rotation(self) -> bool {
        self as usize >= 3
    }
}

/// The freedoms of a fit and the frame to whose axes they belong.
///
/// The motion turns about X, Y and Z through the origin of the frame, about Z first, and then translates along its axes.
/// A machine can correct it by just these values. The frame is given in the axes of the nominal mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Freedoms {
    frame: Frame,
    free: Vec<Freedom>,
}

impl Freedoms {
    /// All six, along and about the axes of the nominal mesh.
    pub fn all() -> Self {
        Self { frame: Frame::IDENTITY, free: Freedom::ALL.to_vec() }
    }

    /// The freedoms `free` along and about the axes of `frame` (mm, in the axes of the nominal mesh).
    ///
    /// # Errors
    /// [`MeasuredError::BadSetting`] for no freedom, and for a frame whose axes are not orthogonal unit vectors.
    pub fn of(frame: Frame, free: &[Freedom]) -> Result<Self, MeasuredError> {
        let mut free = free.to_vec();
        free.sort_unstable();
        free.dedup();
        if free.is_empty() {
            let rule = "give at least one of X, Y, Z, A, B, C";
            return Err(MeasuredError::BadSetting { name: "freedoms of the fit", value: "none".to_owned(), rule });
        }
        let axes = DMat3::from_cols(frame.x, frame.y, frame.z);
        let off =
            (axes.transpose() * axes - DMat3::IDENTITY).to_cols_array().iter().fold(0.0f64, |m, x| m.max(x.abs()));
        // Written so that a frame with a NaN fails.
        let is_frame = off < 1e-9 && axes.determinant() > 0.0 && frame.origin.is_finite();
        if !is_frame {
            let rule = "its axes must be a right-handed set of orthogonal unit vectors";
            return Err(MeasuredError::BadSetting { name: "frame of the fit", value: format!("{frame:?}"), rule });
        }
        Ok(Self { frame, free })
    }

    /// The freedoms in the order X, Y, Z, A, B, C.
    pub fn list(&self) -> &[Freedom] {
        &self.free
    }

    /// The frame, in the axes of the nominal mesh.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The value of a freedom among `values`, which stand in the order of [`Self::list`]; 0 for one that is not free.
    fn value(&self, values: &DVector<f64>, freedom: Freedom) -> f64 {
        self.free.iter().position(|f| *f == freedom).map_or(0.0, |i| values[i])
    }

    /// Rotations about X, Y and Z, and the translation, in the frame.
    fn parts(&self, values: &DVector<f64>) -> (DQuat, DQuat, DQuat, DVec3) {
        let [x, y, z, a, b, c] = Freedom::ALL.map(|freedom| self.value(values, freedom));
        (DQuat::from_rotation_x(a), DQuat::from_rotation_y(b), DQuat::from_rotation_z(c), DVec3::new(x, y, z))
    }

    /// The motion with `values` (mm, rad), in the axes of the nominal mesh.
    pub(super) fn motion(&self, values: &DVector<f64>) -> DAffine3 {
        let (a, b, c, shift) = self.parts(values);
        let frame = DAffine3 {
            matrix3: DMat3::from_cols(self.frame.x, self.frame.y, self.frame.z),
            translation: self.frame.origin,
        };
        frame * DAffine3::from_rotation_translation((a * b * c).normalize(), shift) * frame.inverse()
    }

    /// The twists of the motion at `values`: for each freedom a column with the angular velocity, and the velocity of
    /// the point `at` that is carried along, for a unit change of its value.
    pub(super) fn twists(&self, values: &DVector<f64>, at: DVec3) -> DMatrix<f64> {
        let (a, b, _, shift) = self.parts(values);
        let centre = self.frame.to_parent(shift);
        let mut twists = DMatrix::zeros(6, self.free.len());
        for (k, freedom) in self.free.iter().enumerate() {
            let direction = match freedom {
                Freedom::X | Freedom::A => DVec3::X,
                Freedom::Y => DVec3::Y,
                Freedom::Z => DVec3::Z,
                Freedom::B => a * DVec3::Y,
                Freedom::C => a * (b * DVec3::Z),
            };
            let direction = self.frame.direction_to_parent(direction);
            let (turn, shift) = if freedom.is_rotation() {
                (direction, direction.cross(at - centre))
            } else {
                (DVec3::ZERO, direction)
            };
            for (row, value) in turn.to_array().into_iter().chain(shift.to_array()).enumerate() {
                twists[(row, k)] = value;
            }
        }
        twists
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twists_are_the_derivatives_of_the_motion() {
        let frame = Frame::from_x_and_z_hint(DVec3::new(3.0, -2.0, 5.0), DVec3::new(0.2, 1.0, 0.4), DVec3::Z);
        let freedoms = Freedoms::of(frame, &Freedom::ALL).unwrap();
        let values = DVector::from_vec(vec![0.4, -0.3, 0.2, 0.1, -0.2, 0.3]);
        let p = DVec3::new(10.0, 4.0, -7.0);
        let at = |values: &DVector<f64>| freedoms.motion(values).transform_point3(p);
        let twists = freedoms.twists(&values, at(&values));
        for k in 0..6 {
            let moved = |h: f64| {
                let mut moved = values.clone();
                moved[k] += h;
                at(&moved)
            };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            let twist = DVec3::new(twists[(3, k)], twists[(4, k)], twists[(5, k)]);
            assert!((slope - twist).length() < 1e-8, "{k}: {slope} {twist}");
        }
    }

    #[test]
    fn freedoms_that_make_no_sense_are_refused() {
        assert!(Freedoms::of(Frame::IDENTITY, &[]).is_err());
        let skew = Frame { y: DVec3::new(0.0, 1.0, 0.1), ..Frame::IDENTITY };
        assert!(Freedoms::of(skew, &[Freedom::X]).is_err());
        let nan = Frame { y: DVec3::NAN, ..Frame::IDENTITY };
        assert!(Freedoms::of(nan, &[Freedom::X]).is_err());
        let twice = Freedoms::of(Frame::IDENTITY, &[Freedom::C, Freedom::X, Freedom::C]).unwrap();
        assert_eq!(twice.list(), [Freedom::X, Freedom::C]);
    }
}
