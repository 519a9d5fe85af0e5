// adafruit/Adafruit_AHRS: settings are the rate of begin, Hz.
#include <math.h>
#include <stdint.h>
#include "Arduino.h"
#define long int32_t     // as it is on the boards: invSqrt reads a float as a long
#include "Adafruit_AHRS_Madgwick.cpp"
#undef sampleFreqDef
#include "Adafruit_AHRS_Mahony.cpp"
#undef long
#include "Adafruit_AHRS_NXPFusion.cpp"
#undef X
#undef Y
#undef Z
#include "loop.hpp"

static void run(Adafruit_AHRS_FusionInterface &filter, long count, const Reading *readings, Attitude *attitudes,
                const double *settings) {
    filter.begin(settings[0]);
    each(count, readings, attitudes, [&](const Reading &reading, double) -> Attitude {
        give(reading, [&](auto... values) { filter.update(values...); });
        float w, x, y, z;
        filter.getQuaternion(&w, &x, &y, &z);
        return {x, y, z, w};
    });
}

extern "C" void madgwick(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    Adafruit_Madgwick filter;
    run(filter, count, readings, attitudes, settings);
}

extern "C" void mahony(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    Adafruit_Mahony filter;
    run(filter, count, readings, attitudes, settings);
}

extern "C" void nxp(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    Adafruit_NXPSensorFusion *filter = new Adafruit_NXPSensorFusion();  // with zeros where it sets nothing, as a global
    run(*filter, count, readings, attitudes, settings);
    delete filter;
}
