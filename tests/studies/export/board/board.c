// A Cortex-M4 without a system: samples from samples.bin, estimates to estimates.bin, what a step costs to cost.bin.
#include <stdint.h>

#include OBSERVER_H

enum { OPEN = 1, CLOSE = 2, WRITE = 5, READ = 6, EXIT = 0x18, READING = 1, WRITING = 5, DONE = 0x20026 };
enum { PAINT = 0x5ca1ab1e, PAINTED = 4096, SYSTICK_MASK = 0xffffff };

#define CPACR (*(volatile uint32_t *)0xE000ED88)
#define SYSTICK ((volatile uint32_t *)0xE000E010)

extern uint32_t stack_top;
int main(void);

void reset(void) {
    CPACR |= 0xFu << 20;  // the floating point unit is off at first
    __asm volatile("dsb\n isb");
    main();
}

__attribute__((section(".vectors"), used)) static const void *const VECTORS[16] = {&stack_top, (void *)reset};

// Semihosting: the emulator opens, reads and writes files for us.
static int host(int operation, const void *arguments) {
    register int r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = arguments;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static int open_file(const char *name, uintptr_t mode, uintptr_t length) {
    const uintptr_t arguments[] = {(uintptr_t)name, mode, length};
    return host(OPEN, arguments);
}

// Zero if all bytes were read or written.
static int move(int operation, int file, const void *bytes, uintptr_t count) {
    const uintptr_t arguments[] = {(uintptr_t)file, (uintptr_t)bytes, count};
    return host(operation, arguments);
}

// How many bytes of the painted part of the stack have been used.
static uint32_t used(const volatile uint32_t *floor) {
    uint32_t untouched = 0;
    while (untouched < PAINTED && floor[untouched] == PAINT) ++untouched;
    return 4 * (PAINTED - untouched);
}

int main(void) {
    OBSERVER(state) state;
    OBSERVER(input) input;
    OBSERVER(estimate) estimate;
    uint32_t cost[3] = {0, 0, 0};  // ticks of all steps, steps, bytes of stack
    const int samples = open_file("samples.bin", READING, 11), estimates = open_file("estimates.bin", WRITING, 13);
    volatile uint32_t *floor;
    __asm volatile("mov %0, sp" : "=r"(floor));
    floor -= PAINTED;
    SYSTICK[1] = SYSTICK_MASK, SYSTICK[0] = 5;
    for (int begun = 0; move(READ, samples, &input, sizeof input) == 0; begun = 1) {
        if (!begun) {
            OBSERVER(init)(&state, &OBSERVER(defaults), &input, &estimate);
            for (int i = 0; i < PAINTED; ++i) floor[i] = PAINT;
        } else {
            const uint32_t before = SYSTICK[2];
            OBSERVER(step)(&state, &OBSERVER(defaults), &input, &estimate);
            cost[0] += (before - SYSTICK[2]) & SYSTICK_MASK, ++cost[1];
        }
        move(WRITE, estimates, &estimate, sizeof estimate);
    }
    cost[2] = used(floor);
    move(WRITE, open_file("cost.bin", WRITING, 8), cost, sizeof cost);
    host(EXIT, (const void *)DONE);
    return 0;
}
