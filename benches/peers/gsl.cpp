// GSL: Prince-Dormand 8(9), and the linear multistep method of Adams in Nordsieck form.
#include "peer.hpp"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <memory>

namespace {

constexpr double FIRST_STEP = 1e-4;

template <class System> int call(double t, const double y[], double f[], void *system) {
    (*static_cast<System *>(system))(y, f, t);
    return GSL_SUCCESS;
}

// A step function with its control and evolution for `size` states.
struct Solver {
    gsl_odeiv2_step *step;
    gsl_odeiv2_control *control;
    gsl_odeiv2_evolve *evolve;

    Solver(const gsl_odeiv2_step_type *type, size_t size, double tolerance)
        : step(gsl_odeiv2_step_alloc(type, size)),
          control(gsl_odeiv2_control_y_new(tolerance, tolerance)),
          evolve(gsl_odeiv2_evolve_alloc(size)) {}
    Solver(const Solver &) = delete;
    ~Solver() {
        gsl_odeiv2_evolve_free(evolve);
        gsl_odeiv2_control_free(control);
        gsl_odeiv2_step_free(step);
    }
    void reset() {
        gsl_odeiv2_step_reset(step);
        gsl_odeiv2_evolve_reset(evolve);
    }
};

// Prince-Dormand for the backlash.
struct Method {
    Solver two, four;
    double h = FIRST_STEP;

    explicit Method(double tolerance)
        : two(gsl_odeiv2_step_rk8pd, 2, tolerance), four(gsl_odeiv2_step_rk8pd, 4, tolerance) {}

    template <int N> Solver &solver() { return N == 2 ? two : four; }

    template <int N, class System> double advance(System &system, double t, double *y, double limit) {
        gsl_odeiv2_system described = {call<System>, nullptr, N, &system};
        Solver &s = solver<N>();
        double next = h;
        if (gsl_odeiv2_evolve_apply(s.evolve, s.control, s.step, &described, &t, limit, &next, y) != GSL_SUCCESS)
            return NAN;
        // A step cut by the output says nothing against a longer one.
        h = t == limit ? std::max(h, next) : next;
        return t;
    }
    template <int N, class System> void single(System &system, double t, const double *y, double h, double *into) {
        gsl_odeiv2_system described = {call<System>, nullptr, N, &system};
        double error[N];
        std::copy(y, y + N, into);
        gsl_odeiv2_step_apply(solver<N>().step, t, h, into, error, nullptr, nullptr, &described);
    }
    void restart() {
        two.reset();
        four.reset();
        h = std::min(h, 1e-3);
    }
};

template <class System>
int integrate(const gsl_odeiv2_step_type *type, double tolerance, System system, long steps, double *out) {
    gsl_odeiv2_system described = {call<System>, nullptr, 2, &system};
    std::unique_ptr<gsl_odeiv2_driver, void (*)(gsl_odeiv2_driver *)> driver(
        gsl_odeiv2_driver_alloc_y_new(&described, type, FIRST_STEP, tolerance, tolerance), gsl_odeiv2_driver_free);
    double t = 0.0, y[2] = {System::start[0], System::start[1]};
    for (long i = 0; i < steps; i++) {
        if (gsl_odeiv2_driver_apply(driver.get(), &t, works::output_time(i + 1), y) != GSL_SUCCESS) return -1;
        peer::put<System>(out, i, y);
        if (System::corner && i + 1 == std::lround(System::corner * 1e3)) gsl_odeiv2_driver_reset(driver.get());
    }
    return 0;
}

}  // namespace

const char *peer_methods() { return "GSL rk8pd;GSL msadams"; }

int peer_solve(int method, int work, double tolerance, double *out, double *cpu_seconds) {
    gsl_set_error_handler_off();
    peer::Clock clock;
    int result;
    if (work == works::M3) {
        // The multistep method cannot take single steps of a given length.
        if (method != 0) return 1;
        Method one(tolerance);
        result = peer::BacklashRun<Method>(one).run(out);
    } else {
        const gsl_odeiv2_step_type *type = method == 0 ? gsl_odeiv2_step_rk8pd : gsl_odeiv2_step_msadams;
        result = peer::with_work(
            work, [&](auto system) { return integrate(type, tolerance, system, works::STEPS[work], out); });
    }
    *cpu_seconds = clock.seconds();
    return result;
}
