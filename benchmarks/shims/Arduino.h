// What the libraries take from Arduino's header, for a computer.
#pragma once
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define DEG_TO_RAD (PI / 180.0)
#define RAD_TO_DEG (180.0 / PI)

static inline uint32_t micros(void) { return 0; }  // of a clock that no shim uses
