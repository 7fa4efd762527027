// Must not compile, see layers_tests.cmake: records know nothing of the frame they are made for.
#include "record/record.h"
#include "render/render.h"
