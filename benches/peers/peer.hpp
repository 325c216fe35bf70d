// What a peer offers: one of the works under way, which goes from output to output. peer.cpp gives it to
// benches/peers/compare.py in process and as an FMU; and the drives with backlash on top of a one-step method.
#pragma once

#include "works.hpp"

#include <algorithm>
#include <limits>
#include <memory>

namespace peer {

struct Run {
    virtual ~Run() = default;
    // Goes on to the time `t` of the next output and puts two numbers there; false where that fails.
    virtual bool advance(double t, double *out) = 0;
};

// The methods, separated by ";".
extern const char *const METHODS;

// A work at its start; null where the method does not do it. `setting` is the relative tolerance (for a fixed step: steps
// per millisecond).
std::unique_ptr<Run> start(int method, int work, double setting);

template <class Work> void put(double *out, const double *y) {
    for (int k = 0; k < 2; k++) out[k] = y[Work::output[k]] * Work::scale[k];
}

// Whether the motion has its corner at this time, which a master may have rounded otherwise.
template <class Work> bool is_corner(double t) { return Work::corner > 0.0 && std::abs(t - Work::corner) < 1e-9; }

// `make(work)` for the smooth work, or the drive with backlash, of this number.
template <class F> std::unique_ptr<Run> with_work(int work, F make) {
    switch (work) {
    case works::M1: return make(works::ElasticOutput<double>{});
    case works::M2: return make(works::ElasticShaft<double>{});
    case works::M4: return make(works::RigidMachine<double>{});
    case works::RAMP: return make(works::Ramp<double>{});
    case works::M5: return make(works::Train<double>{});
    default: return nullptr;
    }
}
template <class F> std::unique_ptr<Run> with_drive(int work, F make) {
    switch (work) {
    case works::M3: return make(works::Backlash<double>{});
    case works::M6: return make(works::TrainBacklash<double>{});
    default: return nullptr;
    }
}

// A drive with backlash and any method that can make one step.
//
// `Method` holds two instances of a one-step method, for BOUND and for LOOSE states, and offers for both numbers N
//   R advance<N>(system, t, y, limit)        one step chosen by the method, not beyond `limit`; the time reached
//   void single<N>(system, t, y, h, into)    one step of length h without error control
//   void restart()                           after an event
// Events are looked for at the end of every step, and found by a bracketing secant method on the length of the step
// (Illinois), as precisely as time is resolved.
template <class Drive, class Method, class R = double> struct BacklashRun final : Run {
    static constexpr int BOUND = Drive::BOUND, LOOSE = Drive::LOOSE;
    static constexpr R RESOLUTION = 2 * std::numeric_limits<R>::epsilon();
    Drive drive;
    Method method;
    R t = 0, y[LOOSE] = {};
    int flank = 0;  // 1: on A, -1: on B, 0: free
    int left = 0;   // the flank that was left last
    long events = 0;

    explicit BacklashRun(const Drive &d, const Method &m) : drive(d), method(m) { flank = drive.start(y); }

    // Past this number of events the answer is worth nothing (some 300 are right).
    static constexpr long TOO_MANY = 20000;

    bool advance(double end, double *out) override {
        if (!reach(end)) return false;
        R both[2];
        drive.outputs(y, t, flank, both);
        std::copy(both, both + 2, out);
        return true;
    }

    bool reach(R end) {
        while (t < end)
            if (flank ? !contact_step(end) : !free_step(end)) return false;
        return true;
    }

    bool contact_step(R end) {
        const int side = flank;
        auto system = [&](const R *y, R *f, R t) { drive.contact(y, f, t, side); };
        auto guard = [&](const R *y, R t) { return drive.force(y, t, side); };
        R y0[BOUND], t0 = t;
        std::copy(y, y + BOUND, y0);
        t = method.template advance<BOUND>(system, t, y, end);
        if (!(t > t0) || !std::isfinite(y[BOUND - 1])) return false;
        if (guard(y, t) < 0) {
            locate<BOUND>(system, guard, t0, y0);
            drive.on_flank(y, t, side);
            left = side;
            flank = 0;
            method.restart();
            return ++events < TOO_MANY;
        }
        return true;
    }

    bool free_step(R end) {
        auto system = [&](const R *y, R *f, R) { drive.free(y, f); };
        R y0[LOOSE], t0 = t;
        std::copy(y, y + LOOSE, y0);
        t = method.template advance<LOOSE>(system, t, y, end);
        if (!(t > t0) || !std::isfinite(y[BOUND - 1])) return false;
        for (int side : {-left, left}) {
            auto guard = [&](const R *y, R t) { return drive.gap(y, t, side); };
            if (guard(y, t) < 0) {
                locate<LOOSE>(system, guard, t0, y0);
                left = side;
                flank = drive.impact(y, t, side) ? side : 0;
                method.restart();
                return ++events < TOO_MANY;
            }
        }
        return true;
    }

    // Moves t, y back from the end of the step that began with t0, y0 to the instant at which `guard` vanishes.
    template <int N, class System, class Guard> void locate(System system, Guard guard, R t0, const R *y0) {
        R low = 0, high = t - t0, g_low = guard(y0, t0), g_high = guard(y, t), z[N];
        if (!(g_low > 0)) {
            // A flight starts with a gap of zero: look for an instant at which the flank is left.
            R h = high;
            for (int i = 0; i < 8 && !(g_low > 0); i++) {
                h *= R(0.5);
                method.template single<N>(system, t0, y0, h, z);
                g_low = guard(z, t0 + h);
            }
            if (!(g_low > 0)) return;
            low = h;
        }
        int kept = 0;
        for (int i = 0; i < 60 && high - low > RESOLUTION * (1 + t0); i++) {
            R h = (low * g_high - high * g_low) / (g_high - g_low);
            if (!(h > low && h < high)) h = R(0.5) * (low + high);
            method.template single<N>(system, t0, y0, h, z);
            R g = guard(z, t0 + h);
            std::copy(z, z + N, y);
            t = t0 + h;
            if (g == 0) return;
            if (g > 0) {
                low = h, g_low = g;
                if (kept > 0) g_high *= R(0.5);
                kept = 1;
            } else {
                high = h, g_high = g;
                if (kept < 0) g_low *= R(0.5);
                kept = -1;
            }
        }
    }
};

}  // namespace peer
