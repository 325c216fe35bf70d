// A peer as compare.py calls it: in process, or as an FMU, for which this has the functions that fmu.c calls.
#include "peer.hpp"

#include <cstdio>
#include <ctime>
#include <exception>

extern "C" const char *peer_methods() { return peer::METHODS; }

// `out` takes two numbers per millisecond. Returns 0, 1 where the method does not do this work, -1 where it failed.
extern "C" int peer_solve(int method, int work, double setting, double *out, double *cpu_seconds) try {
    auto now = [] {
        timespec t;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double begin = now();
    std::unique_ptr<peer::Run> run = peer::start(method, work, setting);
    if (!run) return 1;
    for (long i = 0; i < works::STEPS[work]; i++)
        if (!run->advance(works::output_time(i + 1), out + 2 * i)) return -1;
    run.reset();
    *cpu_seconds = now() - begin;
    return 0;
} catch (const std::exception &) {
    return -1;
}

// The peer as an FMU. Its guid says "method work"; the variables 0 to 2 are outputs, the third of which repeats the first, 3
// is the setting. The motion of the ramp is known in advance: what is set at its inputs is not looked at.
struct Instance {
    int method = 0, work = 0;
    double setting = 0.0, outputs[2] = {};
    std::unique_ptr<peer::Run> run;
};
enum { OK, ERROR = 3 };

extern "C" void *fmi2Instantiate(const char *, int, const char *guid, const char *, const void *, int, int) {
    auto *instance = new Instance;
    if (std::sscanf(guid, "%d %d", &instance->method, &instance->work) == 2) return instance;
    delete instance;
    return nullptr;
}
extern "C" int fmi2SetupExperiment(void *, int, double, double, int, double) { return OK; }
extern "C" int fmi2EnterInitializationMode(Instance *instance) {
    instance->run = peer::start(instance->method, instance->work, instance->setting);
    return instance->run ? OK : ERROR;
}
extern "C" int fmi2ExitInitializationMode(void *) { return OK; }
extern "C" int fmi2SetReal(Instance *instance, const unsigned *variables, size_t count, const double *values) {
    for (size_t i = 0; i < count; i++)
        if (variables[i] == 3) instance->setting = values[i];
    return OK;
}
extern "C" int fmi2GetReal(Instance *instance, const unsigned *variables, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) values[i] = instance->outputs[variables[i] % 2];
    return OK;
}
extern "C" int fmi2DoStep(Instance *instance, double t, double step, int) try {
    return instance->run->advance(t + step, instance->outputs) ? OK : ERROR;
} catch (const std::exception &) {
    return ERROR;
}
extern "C" int fmi2Terminate(void *) { return OK; }
extern "C" void fmi2FreeInstance(Instance *instance) { delete instance; }
