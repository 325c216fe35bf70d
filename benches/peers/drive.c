/* Drives one FMU and prints what it costs: the work that the benchmarks count, alone.
 *
 *   drive FOLDER "OUTPUT OUTPUT …"|all STEPS [step=1e-3] [repeat=7] [ramp=SPEED,TIME] [values=FILE] [NAME=VALUE …]
 *
 * FOLDER is an unzipped FMU; the outputs are read after each of the STEPS communication steps, one by one, or `all` by one
 * call. NAME=VALUE
 * sets a parameter of the FMU before initialisation. `values` takes the outputs, text with one line per step.
 * `benches/peers/cost` calls it on the works, also under callgrind. */
#include "fmu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int write_values(const char *path, double step, long count, const double *values, int outputs) {
    FILE *file = fopen(path, "w");
    if (!file) return perror(path), -1;
    for (long i = 0; i < count; i++) {
        fprintf(file, "%.17g", (double)(i + 1) * step);
        for (int k = 0; k < outputs; k++) fprintf(file, " %.17g", values[outputs * i + k]);
        fputc('\n', file);
    }
    return fclose(file);
}

int main(int argc, char **argv) {
    if (argc < 4) return fprintf(stderr, "usage: see the top of drive.c\n"), 2;
    long count = strtol(argv[3], NULL, 10), repeat = 7;
    double step = 1e-3;
    Ramp ramp = {0.0, 0.0};
    const char *file = NULL;
    char settings[512] = "";
    for (int i = 4; i < argc; i++) {
        if (sscanf(argv[i], "step=%lf", &step) == 1 || sscanf(argv[i], "repeat=%ld", &repeat) == 1
            || sscanf(argv[i], "ramp=%lf,%lf", &ramp.speed, &ramp.time) == 2)
            continue;
        if (!strncmp(argv[i], "values=", 7)) {
            file = argv[i] + 7;
            continue;
        }
        strncat(settings, argv[i], sizeof settings - strlen(settings) - 2);
        strcat(settings, " ");
    }
    Fmu fmu;
    if (fmu_open(&fmu, argv[1], argv[2], ramp.time > 0.0)) return 1;
    double *values = malloc((size_t)count * (size_t)fmu.count * sizeof *values);
    double *steps = malloc((size_t)repeat * sizeof *steps), *starts = malloc((size_t)repeat * sizeof *starts);
    if (!values || !steps || !starts) return fprintf(stderr, "not enough memory\n"), 1;
    for (long i = 0; i < repeat; i++) {
        FmuTimes times;
        if (fmu_run(&fmu, settings, ramp.time > 0.0 ? &ramp : NULL, step, count, values, &times)) return 1;
        steps[i] = times.steps;
        starts[i] = times.instantiate + times.initialise;
    }
    qsort(steps, (size_t)repeat, sizeof *steps, ascending);
    qsort(starts, (size_t)repeat, sizeof *starts, ascending);
    printf("%.1f ns per step, %.3f ms for %ld steps, %.3f ms before (medians of %ld; least %.1f ns)\n",
           1e9 * steps[repeat / 2] / (double)count, 1e3 * steps[repeat / 2], count, 1e3 * starts[repeat / 2], repeat,
           1e9 * steps[0] / (double)count);
    if (file && write_values(file, step, count, values, fmu.count)) return 1;
    free(starts), free(steps), free(values);
    fmu_close(&fmu);
    return 0;
}
