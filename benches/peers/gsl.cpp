// GSL: Prince-Dormand 8(9), and the linear multistep method of Adams in Nordsieck form.
#include "peer.hpp"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

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

// Prince-Dormand for the drives with backlash.
template <class Drive> struct Method {
    std::shared_ptr<Solver> bound, loose;
    double h = FIRST_STEP;

    explicit Method(double tolerance)
        : bound(std::make_shared<Solver>(gsl_odeiv2_step_rk8pd, Drive::BOUND, tolerance)),
          loose(std::make_shared<Solver>(gsl_odeiv2_step_rk8pd, Drive::LOOSE, tolerance)) {}

    template <int N> Solver &of() { return N == Drive::BOUND ? *bound : *loose; }

    template <int N, class System> double advance(System &system, double t, double *y, double limit) {
        gsl_odeiv2_system described = {call<System>, nullptr, N, &system};
        Solver &s = of<N>();
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
        gsl_odeiv2_step_apply(of<N>().step, t, h, into, error, nullptr, nullptr, &described);
    }
    void restart() {
        bound->reset();
        loose->reset();
        h = std::min(h, 1e-3);
    }
};

template <class System> struct Driver final : peer::Run {
    System system;
    gsl_odeiv2_system described = {call<System>, nullptr, System::N, &system};
    gsl_odeiv2_driver *driver;
    double t = 0.0, y[System::N];

    Driver(const System &s, const gsl_odeiv2_step_type *type, double tolerance)
        : system(s), driver(gsl_odeiv2_driver_alloc_y_new(&described, type, FIRST_STEP, tolerance, tolerance)) {
        system.start(y);
    }
    ~Driver() { gsl_odeiv2_driver_free(driver); }
    bool advance(double end, double *out) override {
        if (gsl_odeiv2_driver_apply(driver, &t, end, y) != GSL_SUCCESS) return false;
        peer::put<System>(out, y);
        if (peer::is_corner<System>(t)) gsl_odeiv2_driver_reset(driver);
        return true;
    }
};

}  // namespace

const char *const peer::METHODS = "GSL rk8pd;GSL msadams";

std::unique_ptr<peer::Run> peer::start(int method, int work, double tolerance) {
    gsl_set_error_handler_off();
    auto run = with_work(work, [&](auto system) {
        const gsl_odeiv2_step_type *type = method == 0 ? gsl_odeiv2_step_rk8pd : gsl_odeiv2_step_msadams;
        return std::make_unique<Driver<decltype(system)>>(system, type, tolerance);
    });
    // The multistep method cannot take single steps of a given length.
    if (run || method != 0) return run;
    return with_drive(work, [&](auto drive) {
        using Drive = decltype(drive);
        return std::make_unique<BacklashRun<Drive, Method<Drive>>>(drive, Method<Drive>(tolerance));
    });
}
