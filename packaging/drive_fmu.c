/* Drives one FMU as a simulator does, on any platform:
 *
 *   drive_fmu FOLDER PLATFORM FILE
 *
 * FOLDER is an unzipped FMU, PLATFORM its folder in binaries/. It runs the default experiment: a shaft at the inputs phi, w
 * and a gathers speed. FILE takes the names of all Reals that the FMU computes and, per communication point, a line of their
 * values, 64 bits in hexadecimal each, since not every C library prints all digits. Then it goes back to a saved state in
 * the middle and repeats the second half, resets and repeats the whole, to the same bits, and lets calls fail. It prints how
 * long loading takes. Returns 0 if all was as it should be. */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifdef _WIN32
#include <windows.h>
#define LIBRARY_SUFFIX "dll"
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *symbol(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
static int full_path(const char *path, char *into, size_t size) { return _fullpath(into, path, size) != NULL; }
#else
#include <dlfcn.h>
#define LIBRARY_SUFFIX "so"
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *symbol(void *library, const char *name) { return dlsym(library, name); }
static int full_path(const char *path, char *into, size_t size) { return size >= 4096 && realpath(path, into) != NULL; }
#endif

typedef void *Component;
typedef void Logger(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger *log;
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
static int (*setup)(Component, int, double, double, int, double);
static int (*enter)(Component), (*leave)(Component), (*terminate)(Component), (*reset)(Component);
static void (*free_instance)(Component);
static int (*set_real)(Component, const unsigned *, size_t, const double *);
static int (*get_real)(Component, const unsigned *, size_t, double *);
static int (*do_step)(Component, double, double, int);
static int (*get_state)(Component, void **), (*set_state)(Component, void *), (*free_state)(Component, void **);

static const struct {
    const char *name;
    void *place;
} FUNCTIONS[] = {
    {"fmi2Instantiate", &instantiate}, {"fmi2SetupExperiment", &setup}, {"fmi2EnterInitializationMode", &enter},
    {"fmi2ExitInitializationMode", &leave}, {"fmi2Terminate", &terminate}, {"fmi2Reset", &reset},
    {"fmi2FreeInstance", &free_instance}, {"fmi2SetReal", &set_real}, {"fmi2GetReal", &get_real},
    {"fmi2DoStep", &do_step}, {"fmi2GetFMUstate", &get_state}, {"fmi2SetFMUstate", &set_state},
    {"fmi2FreeFMUstate", &free_state}};

enum { MOST_OUTPUTS = 256, NAME = 64, TEXT = 4200 };
static char *description, last_message[TEXT], names[MOST_OUTPUTS][NAME];
static unsigned outputs[MOST_OUTPUTS], inputs[3];
static size_t output_count, input_count;
static double start, step;
static long steps;

static double milliseconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static int fail(const char *what, const char *about) {
    fprintf(stderr, "%s: %s\n", what, about);
    return 1;
}

/* Formats as a simulator does; the arguments come through the C library's own variable arguments. */
static void keep_message(void *environment, const char *instance, int status, const char *category, const char *format,
                         ...) {
    (void)environment, (void)instance, (void)status, (void)category;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(last_message, sizeof last_message, format, arguments);
    va_end(arguments);
}

/* The text between `before` and the next quotation mark. */
static int quoted(const char *text, const char *before, char *into, size_t size) {
    const char *beginning = strstr(text, before);
    if (!beginning) return 0;
    beginning += strlen(before);
    size_t length = strcspn(beginning, "\"");
    if (length >= size) return 0;
    memcpy(into, beginning, length);
    into[length] = '\0';
    return 1;
}

static double number(const char *attribute) {
    const char *experiment = strstr(description, "<DefaultExperiment");
    char text[64];
    return experiment && quoted(experiment, attribute, text, sizeof text) ? strtod(text, NULL) : 0.0;
}

static int read_description(const char *folder) {
    char path[TEXT];
    snprintf(path, sizeof path, "%.4000s/modelDescription.xml", folder);
    FILE *file = fopen(path, "rb");
    if (!file) return fail(path, "cannot be read");
    fseek(file, 0, SEEK_END);
    long length = ftell(file);
    rewind(file);
    description = malloc((size_t)length + 1);
    if (!description) return fail(path, "not enough memory");
    description[fread(description, 1, (size_t)length, file)] = '\0';
    fclose(file);

    static const char BEGINNING[] = "<ScalarVariable name=\"";
    for (const char *one = strstr(description, BEGINNING); one; one = strstr(one + 1, BEGINNING)) {
        const char *end = strstr(one, "</ScalarVariable>"), *real = strstr(one, "<Real");
        char name[NAME], reference[16], causality[16];
        if (!real || real > end || !quoted(one, BEGINNING, name, sizeof name)
            || !quoted(one, "valueReference=\"", reference, sizeof reference)
            || !quoted(one, "causality=\"", causality, sizeof causality))
            continue;
        unsigned value = (unsigned)strtoul(reference, NULL, 10);
        if (!strcmp(causality, "input") && (!strcmp(name, "phi") || !strcmp(name, "w") || !strcmp(name, "a")))
            inputs[input_count++ % 3] = value;
        if ((!strcmp(causality, "output") || !strcmp(causality, "local")) && output_count < MOST_OUTPUTS) {
            memcpy(names[output_count], name, sizeof name);
            outputs[output_count++] = value;
        }
    }
    start = number("startTime=\"");
    step = number("stepSize=\"");
    steps = step > 0.0 ? (long)((number("stopTime=\"") - start) / step + 0.5) : 0;
    return output_count && steps ? 0 : fail(path, "neither outputs nor a default experiment");
}

/* The motion at the inputs, which the description lists in the order phi, w, a. */
static int set_inputs(Component instance, double t) {
    static const double A = 10.0;
    double values[3] = {0.5 * A * t * t, A * t, A};
    return input_count == 3 && set_real(instance, inputs, 3, values);
}

static int initialise(Component instance) {
    return setup(instance, 0, 0.0, start, 0, 0.0) || enter(instance) || set_inputs(instance, start) || leave(instance);
}

/* Steps from communication point `from` to `to` and reads all points behind `from`. */
static int run(Component instance, long from, long to, double *values) {
    for (long i = from; i < to; i++) {
        double t = start + (double)i * step;
        if (set_inputs(instance, t) || do_step(instance, t, step, 1)
            || get_real(instance, outputs, output_count, values + (size_t)(i + 1) * output_count))
            return 1;
    }
    return 0;
}

static int write_values(const char *path, const double *values) {
    FILE *file = fopen(path, "wb");
    if (!file) return fail(path, "cannot be written");
    for (size_t i = 0; i < output_count; i++) fprintf(file, "%s%c", names[i], i + 1 < output_count ? ';' : '\n');
    for (size_t i = 0; i < (size_t)(steps + 1) * output_count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        fprintf(file, "%016" PRIx64 "%c", bits, (i + 1) % output_count ? ';' : '\n');
    }
    return fclose(file);
}

int main(int count, char **arguments) {
    if (count != 4) return fail("usage", "drive_fmu FOLDER PLATFORM FILE");
    char folder[TEXT], path[TEXT], location[TEXT], guid[64], identifier[64];
    if (!full_path(arguments[1], folder, sizeof folder)) return fail(arguments[1], "no such folder");
    if (read_description(folder)) return 1;
    if (!quoted(description, " guid=\"", guid, sizeof guid)
        || !quoted(description, " modelIdentifier=\"", identifier, sizeof identifier))
        return fail(folder, "neither guid nor modelIdentifier");
    snprintf(path, sizeof path, "%.4000s/binaries/%.40s/%s." LIBRARY_SUFFIX, folder, arguments[2], identifier);
    double before = milliseconds();
    void *library = load(path);
    if (!library) return fail(path, "cannot be loaded");
    for (size_t i = 0; i < sizeof FUNCTIONS / sizeof *FUNCTIONS; i++) {
        void *function = symbol(library, FUNCTIONS[i].name);
        if (!function) return fail(FUNCTIONS[i].name, "is not exported");
        memcpy(FUNCTIONS[i].place, &function, sizeof function);
    }
    double loaded = milliseconds();
    snprintf(location, sizeof location, "file://%s%.4000s/resources", folder[0] == '/' ? "" : "/", folder);
    for (char *c = location; *c; c++)
        if (*c == '\\') *c = '/';
    const Callbacks callbacks = {keep_message, calloc, free, NULL, NULL};

    if (instantiate(identifier, 1, "another guid", location, &callbacks, 0, 1)) return fail(path, "takes any guid");
    if (!strstr(last_message, guid)) return fail("no word of the guid in", last_message);
    double refused = milliseconds();
    Component instance = instantiate(identifier, 1, guid, location, &callbacks, 0, 0);
    if (!instance) return fail(path, last_message);
    printf("        loaded in %.1f ms, an instance in %.1f ms\n", loaded - before, milliseconds() - refused);

    size_t points = (size_t)(steps + 1) * output_count;
    double *values = calloc(points, sizeof *values), *again = calloc(points, sizeof *again);
    long middle = steps / 2;
    void *state = NULL;
    if (!values || !again) return fail(path, "not enough memory");
    if (initialise(instance) || get_real(instance, outputs, output_count, values) || run(instance, 0, middle, values)
        || get_state(instance, &state) || run(instance, middle, steps, values))
        return fail("the default experiment", last_message);
    memcpy(again, values, (size_t)(middle + 1) * output_count * sizeof *again);
    if (set_state(instance, state) || run(instance, middle, steps, again) || free_state(instance, &state))
        return fail("the second half", last_message);
    if (memcmp(values, again, points * sizeof *values)) return fail(path, "differs after a restored state");
    if (reset(instance) || initialise(instance) || get_real(instance, outputs, output_count, again)
        || run(instance, 0, steps, again))
        return fail("after a reset", last_message);
    if (memcmp(values, again, points * sizeof *values)) return fail(path, "differs after a reset");

    const unsigned unknown = 4000000000u;
    if (!get_real(instance, &unknown, 1, again)) return fail(path, "knows any variable");
    if (!do_step(instance, start, step, 1)) return fail(path, "steps into the past");
    terminate(instance);
    free_instance(instance);
    return write_values(arguments[3], values);
}
