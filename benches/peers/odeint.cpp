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

// The controlled stepper of either method for one number of states.
template <template <int> class Stepper, int N> struct Controlled {
    odeint::controlled_runge_kutta<Stepper<N>> controlled;
    Stepper<N> plain;

    explicit Controlled(double tolerance) : controlled(odeint::make_controlled(tolerance, tolerance, Stepper<N>())) {}

    // One step of about `h`, which becomes that of the next; the time reached.
    template <class System> double advance(System &system, double t, double *y, double limit, double &h) {
        State<N> z;
        std::copy(y, y + N, z.begin());
        Adapter<System> adapter{system};
        for (int i = 0; i < 100; i++) {
            const bool cut = t + h > limit - 1e-3 * h;
            double try_h = cut ? limit - t : h, before = t;
            if (controlled.try_step(adapter, z, t, try_h) == odeint::success) {
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
    template <class System> void single(System &system, double t, const double *y, double h, double *into) {
        State<N> z;
        std::copy(y, y + N, z.begin());
        // The first stage of Dormand-Prince is the last of the step before; here there is none.
        if constexpr (requires { plain.reset(); }) plain.reset();
        plain.do_step(Adapter<System>{system}, z, t, h);
        std::copy(z.begin(), z.end(), into);
    }
    void reset() {
        if constexpr (requires { controlled.reset(); }) controlled.reset();
    }
};

// For the drives with backlash.
template <template <int> class Stepper, class Drive> struct Both {
    Controlled<Stepper, Drive::BOUND> bound;
    Controlled<Stepper, Drive::LOOSE> loose;
    double h = FIRST_STEP;

    explicit Both(double tolerance) : bound(tolerance), loose(tolerance) {}

    template <int N> auto &of() {
        if constexpr (N == Drive::BOUND) return bound;
        else return loose;
    }
    template <int N, class System> double advance(System &system, double t, double *y, double limit) {
        return of<N>().advance(system, t, y, limit, h);
    }
    template <int N, class System> void single(System &system, double t, const double *y, double h, double *into) {
        of<N>().single(system, t, y, h, into);
    }
    void restart() {
        bound.reset();
        loose.reset();
        h = std::min(h, 1e-3);
    }
};

// Dormand-Prince with its dense output; a corner of the motion is an end of one integration.
template <class System> struct Dense final : peer::Run {
    System system;
    decltype(odeint::make_dense_output(0.0, 0.0, Dopri5<System::N>())) stepper;
    double limit = System::corner > 0.0 ? System::corner : std::numeric_limits<double>::infinity();

    Dense(const System &s, double tolerance)
        : system(s), stepper(odeint::make_dense_output(tolerance, tolerance, Dopri5<System::N>())) {
        State<System::N> y;
        system.start(y.data());
        stepper.initialize(y, 0.0, FIRST_STEP);
    }
    bool advance(double t, double *out) override {
        // Nothing is a step that only rounding leaves.
        while (stepper.current_time() < t - 1e-12) {
            if (stepper.current_time() + stepper.current_time_step() > limit)
                stepper.initialize(stepper.current_state(), stepper.current_time(), limit - stepper.current_time());
            stepper.do_step(Adapter<System>{system});
        }
        State<System::N> y;
        stepper.calc_state(t, y);
        if (peer::is_corner<System>(t)) {
            stepper.initialize(y, t, FIRST_STEP);
            limit = std::numeric_limits<double>::infinity();
        }
        peer::put<System>(out, y.data());
        return true;
    }
};

// Runge-Kutta-Fehlberg 7(8) from output to output.
template <class System> struct ToOutputs final : peer::Run {
    System system;
    Controlled<Rkf78, System::N> stepper;
    double t = 0.0, h = FIRST_STEP, y[System::N];

    ToOutputs(const System &s, double tolerance) : system(s), stepper(tolerance) { system.start(y); }
    bool advance(double end, double *out) override {
        while (t < end) {
            const double begin = t;
            t = stepper.advance(system, t, y, end, h);
            if (!(t > begin)) return false;
        }
        if (peer::is_corner<System>(t)) h = FIRST_STEP;
        peer::put<System>(out, y);
        return true;
    }
};

template <template <int> class Stepper> std::unique_ptr<peer::Run> backlash(int work, double tolerance) {
    return peer::with_drive(work, [&](auto drive) {
        using Drive = decltype(drive);
        using Method = Both<Stepper, Drive>;
        return std::make_unique<peer::BacklashRun<Drive, Method>>(drive, Method(tolerance));
    });
}

}  // namespace

const char *const peer::METHODS = "Boost odeint dopri5;Boost odeint rkf78";

std::unique_ptr<peer::Run> peer::start(int method, int work, double tolerance) {
    if (auto run = method == 0 ? backlash<Dopri5>(work, tolerance) : backlash<Rkf78>(work, tolerance)) return run;
    return with_work(work, [&](auto system) -> std::unique_ptr<Run> {
        using System = decltype(system);
        if (method == 0) return std::make_unique<Dense<System>>(system, tolerance);
        return std::make_unique<ToOutputs<System>>(system, tolerance);
    });
}
