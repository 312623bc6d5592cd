//! What the user released for export. A path is approved by proof (see [`nc::approved`]); a plan is released by
//! the user, who has seen it.

use std::sync::Arc;

use super::outcome::PlanOutcome;

/// A plan that may be approved and that the user released for export. It can only be made by [`Released::by_user`].
///
/// ```compile_fail,E0451
/// use sparkpath::workspaces::blisk::job::{plan::PlanOutcome, released::Released};
/// fn unseen(plan: std::sync::Arc<PlanOutcome>) -> Released {
///     Released { plan }
/// }
/// ```
///
/// Nor does the user's word take the place of a proof:
///
/// ```compile_fail,E0308
/// use nc::program::{NcJob, NcProgram, NcSettings};
/// fn program(released: &sparkpath::workspaces::blisk::job::released::Released, post: &nc::post::Post, job: &NcJob) {
///     let _ = NcProgram::new(released, post, &NcSettings::default(), job);
/// }
/// ```
#[derive(Debug, Clone)]
pub struct Released {
    plan: Arc<PlanOutcome>,
    /// Whether the copying motions, and that on the machine, were known to the user.
    is_whole: bool,
}

/// A plan that nobody can release: some path of it has no certificate that holds, or collides on the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("only a certified plan can be released")]
pub struct NotReleased;

impl Released {
    /// The user releases `plan`: this very one, since another search of the same inputs may end elsewhere.
    ///
    /// # Errors
    /// [`NotReleased`] if the plan may not be approved.
    pub fn by_user(plan: &Arc<PlanOutcome>) -> Result<Self, NotReleased> {
        let is_whole = plan.finishing().is_some();
        plan.may_be_approved().then(|| Self { plan: plan.clone(), is_whole }).ok_or(NotReleased)
    }

    /// The plan.
    pub fn plan(&self) -> &Arc<PlanOutcome> {
        &self.plan
    }

    /// Whether the copying motions of the plan were known when it was released.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Whether `plan` is the very plan that was released.
    pub fn is_of(&self, plan: &Arc<PlanOutcome>) -> bool {
        Arc::ptr_eq(&self.plan, plan)
    }
}
