//! Reasons why something cannot be computed.

use files::Invalid;

/// Reason why a formula, a burn, or a schedule cannot be computed: what is wrong, where, and a remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BurningError {
    /// A value lies outside the range for which a rule was fitted, or is not a number.
    #[error(
        "{rule}: {quantity} is {value} {unit}; the rule holds from {least} to {greatest} {unit}: give the figure itself"
    )]
    OutsideRule {
        /// The rule.
        rule: &'static str,
        /// The quantity that it was asked with.
        quantity: &'static str,
        /// Value of this quantity.
        value: f64,
        /// Least value for which the rule holds.
        least: f64,
        /// Greatest value for which the rule holds.
        greatest: f64,
        /// Unit of these values.
        unit: &'static str,
    },
    /// A value that is not possible.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The file has no technology of this id.
    #[error("there is no technology {id}; those of the file are {ids}")]
    NoSuchTechnology {
        /// The id that was asked for.
        id: String,
        /// Ids of the technologies of the file.
        ids: String,
    },
    /// The technology has no step of this name.
    #[error("technology {technology}: there is no step {step}; its steps are {steps}")]
    NoSuchStep {
        /// Id of the technology.
        technology: String,
        /// The name that was asked for.
        step: String,
        /// Names of its steps.
        steps: String,
    },
    /// No step is as fine as wanted.
    #[error(
        "technology {technology}: no step is as fine as VDI {wanted_vdi:.1}; the finest is VDI {finest_vdi:.1}: \
         take another technology or a rougher finish"
    )]
    FinishNotReached {
        /// Id of the technology.
        technology: String,
        /// Wanted finish (VDI 3400).
        wanted_vdi: f64,
        /// Finish of the finest step that has one (VDI 3400).
        finest_vdi: f64,
    },
    /// The current density of the last step is greater than the step allows on this area.
    #[error(
        "technology {technology}: step {step} has {density_a_cm2:.2} A/cm² on this area, {limit_a_cm2:.2} are \
         allowed: take a step of lower current or more frontal area"
    )]
    CurrentDensity {
        /// Id of the technology.
        technology: String,
        /// Name of the step.
        step: String,
        /// Density of the current on the frontal area (A/cm²).
        density_a_cm2: f64,
        /// Greatest density of the step (A/cm²).
        limit_a_cm2: f64,
    },
    /// The side gap and the orbit of the last step reach beyond the electrode's undersize: the step would gouge.
    #[error(
        "technology {technology}: step {step} reaches {:.4} mm beyond the electrode (side gap {gap_mm} mm, orbit \
         {orbit_mm} mm), which has {undersize_mm} mm to burn in: take a finer step, a smaller orbit, or a larger gap", gap_mm + orbit_mm
    )]
    ReachBeyondUndersize {
        /// Id of the technology.
        technology: String,
        /// Name of the step.
        step: String,
        /// Side gap of the step (mm a side).
        gap_mm: f64,
        /// Radius of the step's orbit (mm).
        orbit_mm: f64,
        /// Undersize of the electrode (mm a side).
        undersize_mm: f64,
    },
    /// A schedule or a list would be longer than allowed.
    #[error("{what}: {rows} rows, at most {most} are possible: give fewer channels or electrodes, or allow more wear")]
    TooManyRows {
        /// The list.
        what: &'static str,
        /// Length of the list, as far as it was counted.
        rows: usize,
        /// Greatest length.
        most: usize,
    },
}
