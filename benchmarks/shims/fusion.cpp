// xioTechnologies/Fusion: settings are 1 for those of its advanced example with its bias estimate, 0 for its own.
extern "C" {
#include "Fusion.h"
}
#include "loop.hpp"

static FusionVector vector(const double *xyz) {
    FusionVector found;
    for (int i = 0; i < 3; ++i) found.array[i] = xyz[i];
    return found;
}

extern "C" void fusion(long count, const Reading *readings, Attitude *attitudes, const double *settings) {
    FusionAhrs filter;
    FusionBias bias;
    FusionAhrsInitialise(&filter);
    FusionBiasInitialise(&bias);
    FusionAhrsSettings chosen = fusionAhrsDefaultSettings;
    chosen.sampleRate = 100.0f;
    if (settings[0]) {
        chosen.gyroscopeRange = 2000.0f;
        chosen.accelerationRejection = chosen.magneticRejection = 10.0f;
        chosen.rejectionTimeout = 5.0f;
    }
    FusionAhrsSetSettings(&filter, &chosen);
    each(count, readings, attitudes, [&](const Reading &reading, double step) -> Attitude {
        if (step > 0.0) FusionAhrsSetSamplePeriod(&filter, step);
        FusionVector gyro = vector(reading.gyro);
        if (settings[0]) gyro = FusionBiasUpdate(&bias, gyro);
        FusionAhrsUpdate(&filter, gyro, vector(reading.accelerometer), vector(reading.magnetometer));
        const FusionQuaternion told = FusionAhrsGetQuaternion(&filter);
        return {told.element.x, told.element.y, told.element.z, told.element.w};
    });
}
