// zita-convolver, one block of 64 frames after the other: zita_blocks INPUTS OUTPUTS TAPS SECONDS
// Non-uniform partitions from 64 to 8192 taps; each call waits until all of its share is done (sync), as offline use
// asks for. Prints one line: CPU time of all threads [s], then quantiles 0.5 and 0.99 of the calls' times [us].
#include <sys/resource.h>
#include <zita-convolver.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

const int RATE = 48000, BLOCK = 64;

static double cpu_seconds() {
    rusage used;
    getrusage(RUSAGE_SELF, &used);
    return used.ru_utime.tv_sec + used.ru_stime.tv_sec + 1e-6 * (used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

static float noise() { return 2.0f * std::rand() / float(RAND_MAX) - 1.0f; }

int main(int, char **argument) {
    const int inputs = atoi(argument[1]), outputs = atoi(argument[2]), taps = atoi(argument[3]);
    const int blocks = atof(argument[4]) * RATE / BLOCK;
    Convproc convolver;
    if (convolver.configure(inputs, outputs, taps, BLOCK, BLOCK, Convproc::MAXPART, 0.0f)) {
        std::fprintf(stderr, "error: zita-convolver refuses this configuration\n");
        return 1;
    }
    for (int in = 0; in < inputs; in++)
        for (int out = 0; out < outputs; out++) {
            std::vector<float> response(taps);
            for (int k = 0; k < taps; k++) response[k] = 0.01f * noise() * std::exp(-5.0f * k / taps);
            convolver.impdata_create(in, out, 1, response.data(), 0, taps);
        }
    convolver.start_process(0, SCHED_OTHER);
    std::vector<float> sound(RATE);
    for (float &sample : sound) sample = noise();
    std::vector<double> times(blocks);
    double began = 0.0, sum = 0.0;
    const int warm_up = RATE / BLOCK;
    for (int k = -warm_up; k < blocks; k++) {
        if (k == 0) began = cpu_seconds();
        for (int in = 0; in < inputs; in++)
            std::copy_n(sound.data() + ((k + warm_up) % (RATE / BLOCK)) * BLOCK, BLOCK, convolver.inpdata(in));
        const auto before = std::chrono::steady_clock::now();
        convolver.process(true);
        const auto after = std::chrono::steady_clock::now();
        if (k >= 0) times[k] = std::chrono::duration<double, std::micro>(after - before).count();
        sum += std::fabs(convolver.outdata(0)[0]);
    }
    const double taken = cpu_seconds() - began;
    convolver.stop_process();
    std::sort(times.begin(), times.end());
    if (!(sum > 0.0)) {
        std::fprintf(stderr, "error: the output is silent\n");
        return 1;
    }
    std::printf("%.6f %.4f %.4f\n", taken, times[blocks / 2], times[blocks * 99L / 100]);
}
