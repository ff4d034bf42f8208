#include "poise/scheduler/policy.h"
