// What a peer offers to benches/peers/compare.py, and the backlash on top of a one-step method.
#pragma once

#include "works.hpp"

#include <algorithm>
#include <ctime>

// A list of methods, separated by ";".
extern "C" const char *peer_methods();

// Solves a work; `setting` is the relative tolerance (for a fixed step: steps per millisecond). `out` takes two numbers
// per millisecond. Returns 0, 1 where the method does not do this work, -1 where it failed.
extern "C" int peer_solve(int method, int work, double setting, double *out, double *cpu_seconds);

namespace peer {

struct Clock {
    timespec begin;
    Clock() { clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin); }
    double seconds() const {
        timespec now;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
        return double(now.tv_sec - begin.tv_sec) + 1e-9 * double(now.tv_nsec - begin.tv_nsec);
    }
};

template <class Work, class Y> void put(double *out, long i, const Y &y) {
    out[2 * i] = y[0] * Work::scale[0];
    out[2 * i + 1] = y[1] * Work::scale[1];
}

// Calls `solve` with the smooth work of this number.
template <class F> int with_work(int work, F solve) {
    switch (work) {
    case works::M1: return solve(works::ElasticOutput<double>{});
    case works::M2: return solve(works::ElasticShaft<double>{});
    case works::M4: return solve(works::RigidMachine<double>{});
    case works::RAMP: return solve(works::Ramp<double>{});
    default: return 1;
    }
}

// The backlash with any method that can make one step.
//
// `Method` holds two instances of a one-step method, for two and for four states, and offers for N = 2, 4
//   double advance<N>(system, t, y, limit)   one step chosen by the method, not beyond `limit`; the time reached
//   void single<N>(system, t, y, h, into)    one step of length h without error control
//   void restart()                           after an event
// Events are looked for at the end of every step, and found by a bracketing secant method on the length of the step
// (Illinois), as precisely as time is resolved.
template <class Method> struct BacklashRun {
    works::Backlash drive;
    Method &method;
    double t = 0.0, y[4] = {};
    int flank = 0;  // 1: on A, -1: on B, 0: free
    int left = 0;   // the flank that was left last
    long events = 0;

    explicit BacklashRun(Method &m) : method(m) { drive.start(y, &flank); }

    // Past this number of events the answer is worth nothing (some 300 are right).
    static constexpr long TOO_MANY = 20000;

    int run(double *out) {
        for (long i = 0; i < works::STEPS[works::M3]; i++) {
            double end = works::output_time(i + 1);
            while (t < end)
                if (flank ? !contact_step(end) : !free_step(end)) return -1;
            out[2 * i] = flank ? drive.flank_position(t, flank) : y[2] * works::Backlash::X;
            out[2 * i + 1] = y[0] * works::Backlash::X;
        }
        return 0;
    }

    bool contact_step(double end) {
        const int side = flank;
        auto system = [&](const double *y, double *f, double t) { drive.contact(y, f, t, side); };
        auto guard = [&](const double *y, double t) { return drive.force(y, t, side); };
        double y0[2] = {y[0], y[1]}, t0 = t;
        t = method.template advance<2>(system, t, y, end);
        if (!(t > t0) || !std::isfinite(y[0])) return false;
        if (guard(y, t) < 0.0) {
            locate<2>(system, guard, t0, y0);
            y[2] = drive.flank_position(t, side) / works::Backlash::X;
            y[3] = drive.flank_speed(t) / (works::Backlash::X * works::Backlash::W);
            left = side;
            flank = 0;
            method.restart();
            return ++events < TOO_MANY;
        }
        return true;
    }

    bool free_step(double end) {
        auto system = [&](const double *y, double *f, double) { drive.free(y, f); };
        double y0[4], t0 = t;
        std::copy(y, y + 4, y0);
        t = method.template advance<4>(system, t, y, end);
        if (!(t > t0) || !std::isfinite(y[0])) return false;
        for (int side : {-left, left}) {
            auto guard = [&](const double *y, double t) { return drive.gap(y, t, side); };
            if (guard(y, t) < 0.0) {
                locate<4>(system, guard, t0, y0);
                // Plastic impact: m1 takes the speed of the flank; whether it stays is decided at once.
                y[2] = drive.flank_position(t, side) / works::Backlash::X;
                y[3] = drive.flank_speed(t) / (works::Backlash::X * works::Backlash::W);
                left = side;
                flank = drive.force(y, t, side) > 0.0 ? side : 0;
                method.restart();
                return ++events < TOO_MANY;
            }
        }
        return true;
    }

    // Moves t, y back from the end of the step that began with t0, y0 to the instant at which `guard` vanishes.
    template <int N, class System, class Guard> void locate(System system, Guard guard, double t0, const double *y0) {
        double low = 0.0, high = t - t0, g_low = guard(y0, t0), g_high = guard(y, t), z[N];
        if (!(g_low > 0.0)) {
            // A flight starts with a gap of zero: look for an instant at which the flank is left.
            double h = high;
            for (int i = 0; i < 8 && !(g_low > 0.0); i++) {
                h *= 0.5;
                method.template single<N>(system, t0, y0, h, z);
                g_low = guard(z, t0 + h);
            }
            if (!(g_low > 0.0)) return;
            low = h;
        }
        int kept = 0;
        for (int i = 0; i < 60 && high - low > 4e-16 * (1.0 + t0); i++) {
            double h = (low * g_high - high * g_low) / (g_high - g_low);
            if (!(h > low && h < high)) h = 0.5 * (low + high);
            method.template single<N>(system, t0, y0, h, z);
            double g = guard(z, t0 + h);
            std::copy(z, z + N, y);
            t = t0 + h;
            if (g == 0.0) return;
            if (g > 0.0) {
                low = h, g_low = g;
                if (kept > 0) g_high *= 0.5;
                kept = 1;
            } else {
                high = h, g_high = g;
                if (kept < 0) g_low *= 0.5;
                kept = -1;
            }
        }
    }
};

}  // namespace peer
