// What each shim shares: one reading, one attitude, and the loop over them.
#pragma once

struct Reading {
    double t_s, gyro[3], accelerometer[3], magnetometer[3];
};

struct Attitude {
    double x, y, z, w;
};

// step(reading, seconds since the one before it) returns the attitude after the reading.
template <class Step>
void each(long count, const Reading *readings, Attitude *attitudes, Step step) {
    for (long i = 0; i < count; ++i)
        attitudes[i] = step(readings[i], i ? readings[i].t_s - readings[i - 1].t_s : 0.0);
}

// Give the nine numbers of a reading to a function, in the order gyro, accelerometer, magnetometer, and then others.
template <class Update, class... Others>
void give(const Reading &r, Update update, Others... others) {
    update(r.gyro[0], r.gyro[1], r.gyro[2], r.accelerometer[0], r.accelerometer[1], r.accelerometer[2],
           r.magnetometer[0], r.magnetometer[1], r.magnetometer[2], others...);
}
