/* An FMU for Co-Simulation (FMI 2.0), driven the way a master does it: one communication step after the other, each
 * followed by fmi2GetReal calls of one variable each, or by one call for all. */
#ifndef FMU_H
#define FMU_H

#include <stddef.h>

enum { FMU_MOST_OUTPUTS = 64 };

/* The motion at the inputs phi, w, a: the speed rises linearly from 0 to `speed` [rad/s] within `time` [s] and stays. */
typedef struct {
    double speed, time;
} Ramp;

typedef struct {
    void *library;
    void *functions[10];
    char identifier[64], guid[128], *resources, *description;
    unsigned outputs[FMU_MOST_OUTPUTS], inputs[3];
    int count, together; /* of the outputs, and whether one call reads them */
} Fmu;

/* Loads the library of the unzipped FMU in `folder` and finds the `outputs` (names separated by blanks; `all`: whatever it
 * computes as a Real) in its model description. Returns 0, or -1 after a message. */
int fmu_open(Fmu *fmu, const char *folder, const char *outputs, int has_inputs);

void fmu_close(Fmu *fmu);

typedef struct {
    double instantiate;  /* CPU seconds of fmi2Instantiate, which reads the scene. */
    double initialise;   /* CPU seconds from fmi2SetupExperiment to the end of initialisation. */
    double steps;        /* CPU seconds of all steps with their outputs. */
} FmuTimes;

/* Drives a new instance over `count` steps of `step` [s]. `settings`: parameters as "name=value name=value" or NULL;
 * `ramp`: the motion at the inputs or NULL; `values`: takes a number of each output per step. Returns 0, or -1 after a message. */
int fmu_run(const Fmu *fmu, const char *settings, const Ramp *ramp, double step, long count, double *values,
            FmuTimes *times);

#endif
