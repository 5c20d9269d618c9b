@{sizes}
#define LW_HANDLE_MARK @{mark}

#include "machine.h"

@{body}

