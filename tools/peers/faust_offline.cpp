// A Faust program, offline: EVENTS OUT.wav. Strings 0 to 5 are its sliders freq0, gain0, gate0 and so on; what has an
// input instead gets one sample of the note's strength at its beginning.
#include <algorithm>
#include <map>

#include "offline.h"

#define FAUSTFLOAT float

struct Meta {
    void declare(const char *, const char *) {}
};

struct UI {  // keeps where each slider's value is
    std::map<std::string, FAUSTFLOAT *> place;
    void openTabBox(const char *) {}
    void openHorizontalBox(const char *) {}
    void openVerticalBox(const char *) {}
    void closeBox() {}
    void declare(FAUSTFLOAT *, const char *, const char *) {}
    void addButton(const char *name, FAUSTFLOAT *at) { place[name] = at; }
    void addCheckButton(const char *name, FAUSTFLOAT *at) { place[name] = at; }
    void addHorizontalSlider(const char *name, FAUSTFLOAT *at, float, float, float, float) { place[name] = at; }
    void addVerticalSlider(const char *name, FAUSTFLOAT *at, float, float, float, float) { place[name] = at; }
    void addNumEntry(const char *name, FAUSTFLOAT *at, float, float, float, float) { place[name] = at; }
    void addHorizontalBargraph(const char *, FAUSTFLOAT *, float, float) {}
    void addVerticalBargraph(const char *, FAUSTFLOAT *, float, float) {}
    void set(const std::string &name, float value) {
        if (place.count(name)) *place[name] = value;
    }
};

struct dsp {
    virtual ~dsp() {}
};

<<includeIntrinsic>>
<<includeclass>>

const int RATE = 48000, BLOCK = 64;

int main(int, char **argument) {
    const Piece piece = read_piece(argument[1]);
    auto *program = new mydsp;
    UI sliders;
    program->init(RATE);
    program->buildUserInterface(&sliders);
    std::vector<float> out(piece.frames + BLOCK), in(BLOCK);
    size_t next = 0;
    for (long at = 0; at < piece.frames; at += BLOCK) {
        std::fill(in.begin(), in.end(), 0.0f);
        for (; next < piece.events.size() && piece.events[next].frame < at + BLOCK; next++) {
            const Event &e = piece.events[next];
            const std::string number = std::to_string(e.string);
            if (e.on) {
                in[e.frame - at] += float(e.strength);
                sliders.set("freq" + number, float(e.frequency));
                sliders.set("gain" + number, float(e.strength));
            }
            sliders.set("gate" + number, float(e.on));
        }
        FAUSTFLOAT *inputs[] = {in.data()}, *outputs[] = {out.data() + at};
        program->compute(BLOCK, inputs, outputs);
    }
    out.resize(piece.frames);
    write_wav(argument[2], out, RATE);
    delete program;
}
