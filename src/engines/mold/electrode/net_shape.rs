//! Files of the net shape: what is to come out is the electrode that is a gap smaller, so it is that one that is
//! checked.

use super::design::{Electrode, ElectrodeSet, PartId};
use super::finding::{CheckKind, Finding};
use super::params::Stage;

/// Said where the two do not belong together.
const OTHER_NET: &str = "without gap it is divided or shared otherwise than with it, so that its net shape is not that \
    of an electrode: write undersized shapes";

/// The stage as files of the net shape hold it.
pub(super) fn net(stage: &Stage) -> Stage {
    Stage { gap_mm: 0.0, stock_mm: 0.0, orbit: Default::default(), ..stage.clone() }
}

/// Parts that each burn of an electrode is for.
pub(super) fn burned(electrode: &Electrode) -> Vec<Vec<PartId>> {
    electrode.burns.iter().map(|burn| burn.parts.clone()).collect()
}

/// The electrodes of the files with the findings of those that they become. One that no real electrode is the undersize
/// of was not checked, and fails; so does each region of which a real electrode has no file.
pub(super) fn told_of_real(mut filed: ElectrodeSet, made: ElectrodeSet) -> ElectrodeSet {
    let is_of =
        |a: &Electrode, b: &Electrode| a.stage == b.stage && a.direction == b.direction && burned(a) == burned(b);
    let mut lacking: Vec<usize> = Vec::new();
    let regions = |e: &Electrode| -> Vec<usize> { e.burns.iter().flat_map(|b| &b.parts).map(|p| p.region).collect() };
    for (electrode, findings) in filed.electrodes.iter().zip(&mut filed.checks) {
        match made.electrodes.iter().position(|real| is_of(real, electrode)) {
            Some(real) => joined(findings, &made.checks[real]),
            None => {
                lacking.extend(regions(electrode));
                findings.iter_mut().for_each(not_checked);
            }
        }
    }
    let is_filed = |real: &&Electrode| filed.electrodes.iter().any(|e| is_of(real, e));
    lacking.extend(made.electrodes.iter().filter(|real| !is_filed(real)).flat_map(regions));
    for (number, (plan, made)) in filed.regions.iter_mut().zip(made.regions).enumerate() {
        plan.left = made.left;
        plan.left_out = made.left_out;
        plan.reason = plan.reason.take().or(made.reason);
        plan.proposal = plan.proposal.or(made.proposal);
        if plan.reason.is_none() && lacking.contains(&number) {
            plan.reason = Some(OTHER_NET.to_owned());
        }
    }
    filed
}

/// Failing checks of the net shape, and otherwise the findings for the real electrode, kind by kind.
fn joined(net: &mut [Finding], real: &[Finding]) {
    for net in net.iter_mut().filter(|net| net.holds) {
        if let Some(real) = real.iter().find(|real| real.kind == net.kind) {
            *net = real.clone();
        }
    }
}

/// A finding that tells of the burn of a body without gap, which nobody burns.
fn not_checked(finding: &mut Finding) {
    if matches!(finding.kind, CheckKind::Gouge | CheckKind::Approach | CheckKind::ResidualStock) {
        *finding = Finding::failed(finding.kind, OTHER_NET.to_owned(), ("not_checked", 1.0));
    }
}
