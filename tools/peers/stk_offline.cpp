// Six strings of the Synthesis ToolKit, offline: stk_offline guitar|plucked EVENTS OUT.wav
// "guitar" is stk::Guitar (six Twang waveguides, coupled at the bridge); "plucked" is six of stk::Plucked.
#include <stk/Guitar.h>
#include <stk/Plucked.h>

#include <memory>

#include "offline.h"

const double RATE = 48000.0;
const int BLOCK = 64, STRINGS = 6;

struct Guitar {
    stk::Guitar guitar{STRINGS};
    void event(const Event &e) {
        if (e.on)
            guitar.noteOn(e.frequency, 0.2 + 0.8 * e.strength, e.string);  // below 0.2 it does not pluck
        else
            guitar.noteOff(0.9, e.string);
    }
    double tick() { return guitar.tick(); }
};

struct Plucked {
    std::vector<std::unique_ptr<stk::Plucked>> strings;
    Plucked() {
        for (int s = 0; s < STRINGS; s++) strings.push_back(std::make_unique<stk::Plucked>(60.0));
    }
    void event(const Event &e) {
        if (e.on)
            strings[e.string]->noteOn(e.frequency, e.strength);
        else
            strings[e.string]->noteOff(0.5);
    }
    double tick() {
        double sum = 0.0;
        for (auto &string : strings) sum += string->tick();
        return sum;
    }
};

template <class Instrument>
std::vector<float> render(const Piece &piece) {
    Instrument instrument;
    std::vector<float> out(piece.frames);
    size_t next = 0;
    for (long at = 0; at < piece.frames; at += BLOCK) {
        const long stop = at + BLOCK < piece.frames ? at + BLOCK : piece.frames;
        for (; next < piece.events.size() && piece.events[next].frame < stop; next++)
            instrument.event(piece.events[next]);
        for (long k = at; k < stop; k++) out[k] = 0.1f * float(instrument.tick());
    }
    return out;
}

int main(int, char **argument) {
    stk::Stk::setSampleRate(RATE);
    const Piece piece = read_piece(argument[2]);
    const bool guitar = std::string(argument[1]) == "guitar";
    write_wav(argument[3], guitar ? render<Guitar>(piece) : render<Plucked>(piece), uint32_t(RATE));
}
