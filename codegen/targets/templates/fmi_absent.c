/* What the standard asks for and $name is not for. */
#include <stddef.h>

#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

/* the same number in all versions */
enum { ERROR = 3 };

/* gets or sets variables of a type that none here has: none of them is fine */
#define UNTYPED(name) \
    EXPORTED int name(void *c, const unsigned int *which, size_t n) { \
        (void)c, (void)which; \
        return n ? ERROR : 0; \
    }
/* makes instances of other kinds */
#define UNCREATED(name) \
    EXPORTED void *name(void) { return NULL; }
#define REFUSED(name) \
    EXPORTED int name(void) { return ERROR; }

$functions
