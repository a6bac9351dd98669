// What the offline programs share: the list of events and a WAV file of 32-bit floats.
#pragma once
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

struct Event {
    long frame;
    int string;
    int on;
    double frequency;  // Hz
    double strength;   // 0 to 1
};

struct Piece {
    long frames = 0;
    std::vector<Event> events;
};

inline Piece read_piece(const char *path) {
    std::ifstream file(path);
    Piece piece;
    Event e;
    file >> piece.frames;
    while (file >> e.frame >> e.string >> e.on >> e.frequency >> e.strength) piece.events.push_back(e);
    if (piece.frames <= 0) {
        std::fprintf(stderr, "%s: error: no piece\n", path);
        std::exit(1);
    }
    return piece;
}

inline void write_wav(const char *path, const std::vector<float> &samples, uint32_t rate) {
    FILE *file = std::fopen(path, "wb");
    if (!file) {
        std::perror(path);
        std::exit(1);
    }
    const uint32_t bytes = 4 * samples.size(), riff = bytes + 36, format_bytes = 16, per_second = 4 * rate;
    const uint16_t is_float = 3, channels = 1, frame_bytes = 4, bits = 32;
    std::fwrite("RIFF", 1, 4, file), std::fwrite(&riff, 4, 1, file), std::fwrite("WAVEfmt ", 1, 8, file);
    std::fwrite(&format_bytes, 4, 1, file), std::fwrite(&is_float, 2, 1, file), std::fwrite(&channels, 2, 1, file);
    std::fwrite(&rate, 4, 1, file), std::fwrite(&per_second, 4, 1, file), std::fwrite(&frame_bytes, 2, 1, file);
    std::fwrite(&bits, 2, 1, file), std::fwrite("data", 1, 4, file), std::fwrite(&bytes, 4, 1, file);
    std::fwrite(samples.data(), 4, samples.size(), file);
    std::fclose(file);
}
