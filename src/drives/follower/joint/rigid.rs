//! A rigid follower, moved by the cam itself or by mechanisms: y = U, N = m ÿ − F_L.

use super::{At, Kind, Now, Put, TOOL, TURNS, moving};
use crate::drives::parameter::{Parameter, Parameters};
use crate::drives::variable::Output;
use crate::numerics::taylor::{Scalar, Series};

/// Nothing between cam and tool.
pub struct Rigid;

impl Parameters for Rigid {
    const SECTION: &'static str = "";
    const TABLE: &'static [Parameter<Self>] = &[];
}

static LEVER: [Output; 3] = moving("lever", "", TURNS, false);

impl Kind for Rigid {
    fn outputs<S: Scalar>(&self, now: &Now<'_, S>, put: &mut Put<'_, S>) {
        let Now { at, phi, a, .. } = now;
        let (rigid, [u, u1, _], w, x2) = (&at.follower.rigid, at.cam, at.w, at.shown_lift(*a));
        let (speed, m) = (u1 * w, rigid.m);
        let load = at.on_tool(m, [u, speed]);
        let normal = x2 * m - load;
        // The inertia and the weight of the mechanisms' links count, too.
        let tau = match links(at, *phi) {
            None => u1 * normal,
            Some([inertia, half_slope, weight]) => inertia * *a + half_slope * w * w - weight - u1 * load,
        };
        now.law(put);
        now.moved(&TOOL, [u, speed, x2], put);
        now.reaction("force", [normal, tau], put);
        if rigid.has_lever() {
            let cam = rigid.cam.at_in(at.segment, phi.value()).0;
            let [u, u1, u2] = [0, 1, 2].map(|n| phi.compose([cam[n], cam[n + 1], cam[n + 2]]));
            put.all(&LEVER, [u, u1 * w, u2 * w * w + u1 * *a]);
        }
    }
}

/// J, ½ J′ and T of tool and links at `phi`, T the torque of the links' weight; None without mechanisms.
fn links<S: Scalar>(at: &At<'_, S>, phi: S) -> Option<[S; 3]> {
    let rigid = &at.follower.rigid;
    if rigid.linkage.is_empty() {
        return None;
    }
    let lever = Series::of_derivatives(rigid.cam.at_in(at.segment, phi.value()).0);
    let moved = rigid.linkage.moved(rigid.m, lever, &at.follower.load.frames);
    let [inertia, weight] = [moved.inertia, moved.weight.slope()].map(Series::derivatives);
    let of = |d: [f64; 5], n: usize| phi.compose([d[n], d[n + 1], d[n + 2]]);
    Some([of(inertia, 0), of(inertia, 1) * 0.5, of(weight, 0)])
}
