#define _GNU_SOURCE
#include "fmu.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The part of fmi2FunctionTypes.h that is needed. */
typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;
typedef Component (*Instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
typedef int (*SetupExperiment)(Component, int, double, double, int, double);
typedef int (*Call)(Component);
typedef void (*Free)(Component);
typedef int (*SetReal)(Component, const unsigned *, size_t, const double *);
typedef int (*GetReal)(Component, const unsigned *, size_t, double *);
typedef int (*DoStep)(Component, double, double, int);

enum { INSTANTIATE, SETUP, ENTER, EXIT, SET, GET, STEP, TERMINATE, FREE, FUNCTIONS };
static const char *const NAMES[FUNCTIONS] = {
    "fmi2Instantiate", "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode",
    "fmi2SetReal",     "fmi2GetReal",         "fmi2DoStep",                  "fmi2Terminate",
    "fmi2FreeInstance"};

static void to_stderr(void *environment, const char *instance, int status, const char *category, const char *format,
                      ...) {
    (void)environment, (void)status, (void)category;
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "%s: ", instance);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

static const Callbacks CALLBACKS = {to_stderr, calloc, free, NULL, NULL};

static char *read_text(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    fseek(file, 0, SEEK_END);
    long length = ftell(file);
    rewind(file);
    char *text = malloc((size_t)length + 1);
    size_t got = fread(text, 1, (size_t)length, file);
    text[got] = '\0';
    fclose(file);
    return text;
}

/* The text between `before` and the next quotation mark; 0 where there is none. */
static int quoted(const char *text, const char *before, char *into, size_t size) {
    const char *start = strstr(text, before);
    if (!start) return 0;
    start += strlen(before);
    size_t length = strcspn(start, "\"");
    if (length >= size) return 0;
    memcpy(into, start, length);
    into[length] = '\0';
    return 1;
}

/* The value reference of a variable, which stands behind its name. */
static int reference(const char *description, const char *name, unsigned *into) {
    char pattern[128], number[16];
    snprintf(pattern, sizeof pattern, "<ScalarVariable name=\"%s\" valueReference=\"", name);
    if (!quoted(description, pattern, number, sizeof number)) {
        fprintf(stderr, "there is no variable `%s`\n", name);
        return -1;
    }
    *into = (unsigned)strtoul(number, NULL, 10);
    return 0;
}

/* All Reals that the FMU computes, to be read by one call. */
static int find_all(Fmu *fmu) {
    static const char BEGINNING[] = "<ScalarVariable name=\"";
    fmu->together = 1;
    for (const char *one = strstr(fmu->description, BEGINNING); one; one = strstr(one + 1, BEGINNING)) {
        const char *end = strstr(one, "</ScalarVariable>"), *real = strstr(one, "<Real"), *place = strstr(one, "valueReference=\"");
        char causality[16];
        if (!end || !real || end < real || !place || !quoted(one, "causality=\"", causality, sizeof causality)) continue;
        if (strcmp(causality, "output") && strcmp(causality, "local")) continue;
        if (fmu->count == FMU_MOST_OUTPUTS) return fprintf(stderr, "too many outputs\n"), -1;
        fmu->outputs[fmu->count++] = (unsigned)strtoul(place + strlen("valueReference=\""), NULL, 10);
    }
    return 0;
}

int fmu_open(Fmu *fmu, const char *folder, const char *outputs, int has_inputs) {
    char path[PATH_MAX], full[PATH_MAX], names[256], *state = NULL;
    memset(fmu, 0, sizeof *fmu);
    if (!realpath(folder, full)) return fprintf(stderr, "%s: no such folder\n", folder), -1;
    snprintf(path, sizeof path, "%.4000s/modelDescription.xml", full);
    if (!(fmu->description = read_text(path))) return fprintf(stderr, "%s cannot be read\n", path), -1;
    if (!quoted(fmu->description, " guid=\"", fmu->guid, sizeof fmu->guid)
        || !quoted(fmu->description, " modelIdentifier=\"", fmu->identifier, sizeof fmu->identifier))
        return fprintf(stderr, "%s: neither guid nor modelIdentifier\n", path), -1;
    snprintf(path, sizeof path, "%.4000s/binaries/linux64/%s.so", full, fmu->identifier);
    if (!(fmu->library = dlopen(path, RTLD_NOW | RTLD_LOCAL))) return fprintf(stderr, "%s\n", dlerror()), -1;
    for (int i = 0; i < FUNCTIONS; i++)
        if (!(fmu->functions[i] = dlsym(fmu->library, NAMES[i]))) return fprintf(stderr, "%s\n", dlerror()), -1;
    if (asprintf(&fmu->resources, "file://%s/resources", full) < 0) return -1;
    snprintf(names, sizeof names, "%s", outputs);
    if (!strcmp(names, "all")) {
        if (find_all(fmu)) return -1;
    } else {
        for (char *name = strtok_r(names, " ", &state); name; name = strtok_r(NULL, " ", &state))
            if (fmu->count == FMU_MOST_OUTPUTS || reference(fmu->description, name, &fmu->outputs[fmu->count++])) return -1;
    }
    static const char *const INPUTS[3] = {"phi", "w", "a"};
    for (int i = 0; has_inputs && i < 3; i++)
        if (reference(fmu->description, INPUTS[i], &fmu->inputs[i])) return -1;
    return 0;
}

void fmu_close(Fmu *fmu) {
    if (fmu->library) dlclose(fmu->library);
    free(fmu->resources);
    free(fmu->description);
    memset(fmu, 0, sizeof *fmu);
}

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void inputs_at(const Ramp *ramp, double t, double inputs[3]) {
    double a = ramp->speed / ramp->time, end = ramp->time;
    if (t < end) {
        inputs[0] = 0.5 * a * t * t, inputs[1] = a * t, inputs[2] = a;
    } else {
        inputs[0] = ramp->speed * (t - 0.5 * end), inputs[1] = ramp->speed, inputs[2] = 0.0;
    }
}

static int set_parameters(const Fmu *fmu, Component instance, const char *settings) {
    char text[512], *state = NULL;
    snprintf(text, sizeof text, "%s", settings ? settings : "");
    for (char *one = strtok_r(text, " ", &state); one; one = strtok_r(NULL, " ", &state)) {
        char *equals = strchr(one, '=');
        if (!equals) return fprintf(stderr, "`%s` is not name=value\n", one), -1;
        *equals = '\0';
        unsigned variable;
        double value = strtod(equals + 1, NULL);
        if (reference(fmu->description, one, &variable)) return -1;
        if (((SetReal)fmu->functions[SET])(instance, &variable, 1, &value)) return -1;
    }
    return 0;
}

/* These loops are lean, since what the caller does in them counts as well. */
static inline int step_and_read(const Fmu *fmu, Component instance, double t, double step, double *values) {
    if (((DoStep)fmu->functions[STEP])(instance, t, step, 1)) return -1;
    const GetReal get_real = (GetReal)fmu->functions[GET];
    if (fmu->together) return get_real(instance, fmu->outputs, (size_t)fmu->count, values);
    for (int k = 0; k < fmu->count; k++)
        if (get_real(instance, &fmu->outputs[k], 1, &values[k])) return -1;
    return 0;
}

static int step_through(const Fmu *fmu, Component instance, double step, long count, double *values) {
    for (long i = 0; i < count; i++, values += fmu->count)
        if (step_and_read(fmu, instance, (double)i * step, step, values)) return -1;
    return 0;
}

static int step_through_ramp(const Fmu *fmu, Component instance, const Ramp *ramp, double step, long count,
                             double *values) {
    const SetReal set_real = (SetReal)fmu->functions[SET];
    for (long i = 0; i < count; i++, values += fmu->count) {
        double t = (double)i * step, inputs[3];
        inputs_at(ramp, t, inputs);
        if (set_real(instance, fmu->inputs, 3, inputs)) return -1;
        if (step_and_read(fmu, instance, t, step, values)) return -1;
    }
    return 0;
}

int fmu_run(const Fmu *fmu, const char *settings, const Ramp *ramp, double step, long count, double *values,
            FmuTimes *times) {
    double start = cpu_seconds();
    Component instance =
        ((Instantiate)fmu->functions[INSTANTIATE])(fmu->identifier, 1, fmu->guid, fmu->resources, &CALLBACKS, 0, 0);
    if (!instance) return -1;
    times->instantiate = cpu_seconds() - start;

    int failed = set_parameters(fmu, instance, settings);
    start = cpu_seconds();
    failed = failed || ((SetupExperiment)fmu->functions[SETUP])(instance, 0, 0.0, 0.0, 0, 0.0)
             || ((Call)fmu->functions[ENTER])(instance);
    if (ramp && !failed) {
        double inputs[3];
        inputs_at(ramp, 0.0, inputs);
        failed = ((SetReal)fmu->functions[SET])(instance, fmu->inputs, 3, inputs);
    }
    failed = failed || ((Call)fmu->functions[EXIT])(instance);
    times->initialise = cpu_seconds() - start;

    start = cpu_seconds();
    failed = failed || (ramp ? step_through_ramp(fmu, instance, ramp, step, count, values)
                             : step_through(fmu, instance, step, count, values));
    times->steps = cpu_seconds() - start;
    if (failed) fprintf(stderr, "%s: a call failed\n", fmu->identifier);
    ((Free)fmu->functions[FREE])(instance);
    return failed ? -1 : 0;
}
