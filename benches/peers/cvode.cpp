// SUNDIALS CVODE: Adams with fixed-point iteration and BDF with Newton's, dense output at every millisecond, events by
// its own root finding.
#include "peer.hpp"

#include <array>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

namespace {

template <class System> int call(realtype t, N_Vector y, N_Vector f, void *system) {
    (*static_cast<System *>(system))(NV_DATA_S(y), NV_DATA_S(f), t);
    return 0;
}

void quiet(int, const char *, const char *, char *, void *) {}

// A memory of CVODE for `size` states.
struct Solver {
    SUNContext context;
    N_Vector y;
    void *memory;
    SUNMatrix matrix = nullptr;
    SUNLinearSolver linear = nullptr;
    SUNNonlinearSolver nonlinear = nullptr;
    bool good = true;

    Solver(int method, int size, double tolerance, CVRhsFn function, void *system, const double *start) {
        SUNContext_Create(nullptr, &context);
        y = N_VNew_Serial(size, context);
        std::copy(start, start + size, NV_DATA_S(y));
        memory = CVodeCreate(method == 0 ? CV_ADAMS : CV_BDF, context);
        check(CVodeInit(memory, function, 0.0, y));
        check(CVodeSStolerances(memory, tolerance, tolerance));
        check(CVodeSetUserData(memory, system));
        check(CVodeSetMaxNumSteps(memory, 100000));
        CVodeSetErrHandlerFn(memory, quiet, nullptr);
        if (method == 0) {
            nonlinear = SUNNonlinSol_FixedPoint(y, 0, context);
            check(CVodeSetNonlinearSolver(memory, nonlinear));
        } else {
            matrix = SUNDenseMatrix(size, size, context);
            linear = SUNLinSol_Dense(y, matrix, context);
            check(CVodeSetLinearSolver(memory, linear, matrix));
        }
    }
    Solver(const Solver &) = delete;
    ~Solver() {
        CVodeFree(&memory);
        if (nonlinear) SUNNonlinSolFree(nonlinear);
        if (linear) SUNLinSolFree(linear);
        if (matrix) SUNMatDestroy(matrix);
        N_VDestroy(y);
        SUNContext_Free(&context);
    }
    void check(int flag) { good = good && flag >= 0; }
    double *data() { return NV_DATA_S(y); }
};

// The states of a system or drive at its start.
template <int N, class Work> std::array<double, N> first(const Work &work) {
    std::array<double, N> y = {};
    work.start(y.data());
    return y;
}

template <class System> struct Smooth final : peer::Run {
    System system;
    Solver solver;
    double t = 0.0;

    Smooth(const System &s, int method, double tolerance)
        : system(s), solver(method, System::N, tolerance, call<System>, &system, first<System::N>(s).data()) {
        if (System::corner > 0.0) CVodeSetStopTime(solver.memory, System::corner);
    }
    bool advance(double end, double *out) override {
        solver.check(CVode(solver.memory, end, solver.y, &t, CV_NORMAL));
        peer::put<System>(out, solver.data());
        if (peer::is_corner<System>(t)) {
            solver.check(CVodeReInit(solver.memory, t, solver.y));
            CVodeSetStopTime(solver.memory, 1e9);
        }
        return solver.good;
    }
};

// A drive with backlash; the guards are functions of CVODE's root finding.
template <class Drive> struct Backlash final : peer::Run {
    static constexpr int BOUND = Drive::BOUND, LOOSE = Drive::LOOSE;
    static constexpr double ARMING = 1e-4;
    static constexpr long TOO_MANY = 20000;
    Drive drive;
    int flank = 0, left = 0;
    double armed = 0.0, t = 0.0;
    long events = 0;
    Solver bound, loose;

    static int contact(realtype t, N_Vector y, N_Vector f, void *self) {
        auto *run = static_cast<Backlash *>(self);
        run->drive.contact(NV_DATA_S(y), NV_DATA_S(f), t, run->flank);
        return 0;
    }
    static int free(realtype, N_Vector y, N_Vector f, void *self) {
        static_cast<Backlash *>(self)->drive.free(NV_DATA_S(y), NV_DATA_S(f));
        return 0;
    }
    static int force(realtype t, N_Vector y, realtype *g, void *self) {
        auto *run = static_cast<Backlash *>(self);
        g[0] = run->drive.force(NV_DATA_S(y), t, run->flank);
        return 0;
    }
    static int gaps(realtype t, N_Vector y, realtype *g, void *self) {
        auto *run = static_cast<Backlash *>(self);
        for (int k = 0; k < 2; k++) {
            const int side = k == 0 ? 1 : -1;
            // A flight begins with a gap of zero that grows with the cube of time: its sign is noise at first.
            g[k] = side == run->left && t < run->armed ? 1.0 : run->drive.gap(NV_DATA_S(y), t, side);
        }
        return 0;
    }

    Backlash(const Drive &d, int method, double tolerance)
        : drive(d),
          bound(method, BOUND, tolerance, contact, this, first<LOOSE>(d).data()),
          loose(method, LOOSE, tolerance, free, this, first<LOOSE>(d).data()) {
        flank = drive.start(loose.data());
        int down[2] = {-1, -1};
        for (Solver *solver : {&bound, &loose}) {
            CVodeRootInit(solver->memory, solver == &bound ? 1 : 2, solver == &bound ? force : gaps);
            CVodeSetRootDirection(solver->memory, down);
            CVodeSetNoInactiveRootWarn(solver->memory);
        }
    }
    bool advance(double end, double *out) override {
        while (t < end) {
            Solver &now = flank ? bound : loose;
            int flag = CVode(now.memory, end, now.y, &t, CV_NORMAL);
            if (flag < 0 || events > TOO_MANY) return false;
            if (flag == CV_ROOT_RETURN && !switch_over(now)) return false;
        }
        drive.outputs((flank ? bound : loose).data(), t, flank, out);
        return true;
    }
    bool switch_over(Solver &now) {
        events++;
        if (flank) {
            left = flank;
            std::copy(now.data(), now.data() + BOUND, loose.data());
            drive.on_flank(loose.data(), t, flank);
            flank = 0;
        } else {
            int found[2];
            CVodeGetRootInfo(now.memory, found);
            left = found[0] ? 1 : -1;
            if (drive.impact(loose.data(), t, left)) {
                std::copy(loose.data(), loose.data() + BOUND, bound.data());
                flank = left;
            }
        }
        armed = t + ARMING;
        Solver &next = flank ? bound : loose;
        return CVodeReInit(next.memory, t, next.y) >= 0;
    }
};

}  // namespace

const char *const peer::METHODS = "CVODE Adams;CVODE BDF";

std::unique_ptr<peer::Run> peer::start(int method, int work, double tolerance) {
    auto run = with_work(
        work, [&](auto system) { return std::make_unique<Smooth<decltype(system)>>(system, method, tolerance); });
    if (run) return run;
    return with_drive(
        work, [&](auto drive) { return std::make_unique<Backlash<decltype(drive)>>(drive, method, tolerance); });
}
