// Boost odeint: Dormand-Prince 5 with its dense output, Runge-Kutta-Fehlberg 7(8), which has none.
#include "peer.hpp"

#include <array>
#include <boost/numeric/odeint.hpp>

namespace odeint = boost::numeric::odeint;

namespace {

template <int N> using State = std::array<double, N>;
template <int N> using Dopri5 = odeint::runge_kutta_dopri5<State<N>>;
template <int N> using Rkf78 = odeint::runge_kutta_fehlberg78<State<N>>;

constexpr double FIRST_STEP = 1e-4;

// A system on arrays as odeint calls it.
template <class System> struct Adapter {
    System &system;
    template <class Y> void operator()(const Y &y, Y &f, double t) const { system(y.data(), f.data(), t); }
};

// The controlled stepper of either method for the backlash.
template <template <int> class Stepper> struct Controlled {
    double tolerance;
    odeint::controlled_runge_kutta<Stepper<2>> two = odeint::make_controlled(tolerance, tolerance, Stepper<2>());
    odeint::controlled_runge_kutta<Stepper<4>> four = odeint::make_controlled(tolerance, tolerance, Stepper<4>());
    Stepper<2> one2;
    Stepper<4> one4;
    double h = FIRST_STEP;

    template <int N> auto &controlled() {
        if constexpr (N == 2) return two;
        else return four;
    }
    template <int N> auto &plain() {
        if constexpr (N == 2) return one2;
        else return one4;
    }
    template <int N, class System> double advance(System &system, double t, double *y, double limit) {
        State<N> z;
        std::copy(y, y + N, z.begin());
        Adapter<System> adapter{system};
        for (int i = 0; i < 100; i++) {
            const bool cut = t + h > limit - 1e-3 * h;
            double try_h = cut ? limit - t : h, before = t;
            if (controlled<N>().try_step(adapter, z, t, try_h) == odeint::success) {
                // A step cut by the output says nothing against a longer one.
                h = cut ? std::max(h, try_h) : try_h;
                std::copy(z.begin(), z.end(), y);
                return cut ? limit : t;
            }
            t = before;
            h = try_h;
        }
        return t;
    }
    template <int N, class System> void single(System &system, double t, const double *y, double h, double *into) {
        State<N> z;
        std::copy(y, y + N, z.begin());
        // The first stage of Dormand-Prince is the last of the step before; here there is none.
        if constexpr (requires { plain<N>().reset(); }) plain<N>().reset();
        plain<N>().do_step(Adapter<System>{system}, z, t, h);
        std::copy(z.begin(), z.end(), into);
    }
    void restart() {
        if constexpr (requires { two.reset(); }) two.reset(), four.reset();
        h = std::min(h, 1e-3);
    }
};

template <class Stepper, class System> void integrate(Stepper stepper, System system, long steps, double *out) {
    using Work = System;
    State<2> y = {Work::start[0], Work::start[1]};
    // The outputs from `first` to `last`; a corner of the motion is an end of one integration.
    auto piece = [&](long first, long last) {
        std::vector<double> times;
        for (long i = first; i <= last; i++) times.push_back(works::output_time(i));
        long i = first;
        State<2> at = y;
        odeint::integrate_times(stepper, Adapter<System>{system}, at, times.begin(), times.end(), FIRST_STEP,
                                [&](const State<2> &z, double) {
                                    if (i > first) peer::put<Work>(out, i - 1, z);
                                    if (i == last) y = z;
                                    i++;
                                });
    };
    const long corner = std::lround(Work::corner * 1e3);
    if (corner) piece(0, corner);
    piece(corner, steps);
}

}  // namespace

const char *peer_methods() { return "Boost odeint dopri5;Boost odeint rkf78"; }

int peer_solve(int method, int work, double tolerance, double *out, double *cpu_seconds) try {
    peer::Clock clock;
    int result;
    if (work == works::M3) {
        if (method == 0) {
            Controlled<Dopri5> controlled{tolerance};
            result = peer::BacklashRun<Controlled<Dopri5>>(controlled).run(out);
        } else {
            Controlled<Rkf78> controlled{tolerance};
            result = peer::BacklashRun<Controlled<Rkf78>>(controlled).run(out);
        }
    } else {
        result = peer::with_work(work, [&](auto system) {
            if (method == 0)
                integrate(odeint::make_dense_output(tolerance, tolerance, Dopri5<2>()), system, works::STEPS[work], out);
            else
                integrate(odeint::make_controlled(tolerance, tolerance, Rkf78<2>()), system, works::STEPS[work], out);
            return 0;
        });
    }
    *cpu_seconds = clock.seconds();
    return result;
} catch (const std::exception &) {
    return -1;
}
