// SUNDIALS CVODE: Adams with fixed-point iteration and BDF with Newton's, dense output at every millisecond, events by
// its own root finding.
#include "peer.hpp"

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

void quiet(int, const char *, const char *, char *, void *) {}

template <class System> int integrate(int method, double tolerance, System system, long steps, double *out) {
    Solver solver(method, 2, tolerance, call<System>, &system, System::start);
    CVodeSetErrHandlerFn(solver.memory, quiet, nullptr);
    const long corner = std::lround(System::corner * 1e3);
    if (corner) CVodeSetStopTime(solver.memory, System::corner);
    double t = 0.0;
    for (long i = 0; i < steps && solver.good; i++) {
        solver.check(CVode(solver.memory, works::output_time(i + 1), solver.y, &t, CV_NORMAL));
        peer::put<System>(out, i, solver.data());
        if (corner && i + 1 == corner) {
            solver.check(CVodeReInit(solver.memory, t, solver.y));
            CVodeSetStopTime(solver.memory, works::output_time(steps));
        }
    }
    return solver.good ? 0 : -1;
}

// The drive with backlash; the guards are functions of CVODE's root finding.
struct BacklashCvode {
    works::Backlash drive;
    int flank = 0, left = 0;
    double armed = 0.0;
    static constexpr double ARMING = 1e-4;

    static int contact(realtype t, N_Vector y, N_Vector f, void *self) {
        auto *run = static_cast<BacklashCvode *>(self);
        run->drive.contact(NV_DATA_S(y), NV_DATA_S(f), t, run->flank);
        return 0;
    }
    static int free(realtype, N_Vector y, N_Vector f, void *self) {
        static_cast<BacklashCvode *>(self)->drive.free(NV_DATA_S(y), NV_DATA_S(f));
        return 0;
    }
    static int force(realtype t, N_Vector y, realtype *g, void *self) {
        auto *run = static_cast<BacklashCvode *>(self);
        g[0] = run->drive.force(NV_DATA_S(y), t, run->flank);
        return 0;
    }
    static int gaps(realtype t, N_Vector y, realtype *g, void *self) {
        auto *run = static_cast<BacklashCvode *>(self);
        for (int k = 0; k < 2; k++) {
            const int side = k == 0 ? 1 : -1;
            // A flight begins with a gap of zero that grows with the cube of time: its sign is noise at first.
            g[k] = side == run->left && t < run->armed ? 1.0 : run->drive.gap(NV_DATA_S(y), t, side);
        }
        return 0;
    }

    int run(int method, double tolerance, double *out) {
        using works::Backlash;
        double state[4];
        drive.start(state, &flank);
        Solver bound(method, 2, tolerance, contact, this, state);
        Solver loose(method, 4, tolerance, free, this, state);
        int down[2] = {-1, -1};
        for (Solver *solver : {&bound, &loose}) {
            CVodeSetErrHandlerFn(solver->memory, quiet, nullptr);
            CVodeRootInit(solver->memory, solver == &bound ? 1 : 2, solver == &bound ? force : gaps);
            CVodeSetRootDirection(solver->memory, down);
            CVodeSetNoInactiveRootWarn(solver->memory);
        }
        double t = 0.0;
        long events = 0;
        for (long i = 0; i < works::STEPS[works::M3]; i++) {
            double end = works::output_time(i + 1);
            while (t < end) {
                Solver &now = flank ? bound : loose;
                int flag = CVode(now.memory, end, now.y, &t, CV_NORMAL);
                if (flag < 0 || events > 20000) return -1;
                if (flag != CV_ROOT_RETURN) continue;
                events++;
                double *y = now.data();
                if (flank) {
                    left = flank;
                    double *z = loose.data();
                    std::copy(y, y + 2, z);
                    z[2] = drive.flank_position(t, flank) / Backlash::X;
                    z[3] = drive.flank_speed(t) / (Backlash::X * Backlash::W);
                    flank = 0;
                } else {
                    int found[2];
                    CVodeGetRootInfo(now.memory, found);
                    int side = found[0] ? 1 : -1;
                    double speed = drive.flank_speed(t) / (Backlash::X * Backlash::W);
                    left = side;
                    y[2] = drive.flank_position(t, side) / Backlash::X;
                    y[3] = speed;
                    if (drive.force(y, t, side) > 0.0) {
                        std::copy(y, y + 2, bound.data());
                        flank = side;
                    }
                }
                armed = t + ARMING;
                Solver &next = flank ? bound : loose;
                if (CVodeReInit(next.memory, t, next.y) < 0) return -1;
            }
            out[2 * i] = flank ? drive.flank_position(t, flank) : loose.data()[2] * Backlash::X;
            out[2 * i + 1] = (flank ? bound : loose).data()[0] * Backlash::X;
        }
        return 0;
    }
};

}  // namespace

const char *peer_methods() { return "CVODE Adams;CVODE BDF"; }

int peer_solve(int method, int work, double tolerance, double *out, double *cpu_seconds) {
    peer::Clock clock;
    int result;
    if (work == works::M3)
        result = BacklashCvode().run(method, tolerance, out);
    else
        result = peer::with_work(
            work, [&](auto system) { return integrate(method, tolerance, system, works::STEPS[work], out); });
    *cpu_seconds = clock.seconds();
    return result;
}
