// What observers see: the measurements at the stages of a step, and what a front makes of them for all observers.

enum { N_STAGED = N_MEASURED + N_FRONT };

// What observers compute from the measurements alone, with one set of numbers.
struct FrontPart {
    V *p, *c, *c_near;
};

// What observers see at the four stages of a step: the measurements and what their front makes of them.
struct Sight {
    V staged[4 * N_STAGED];
};

// inlines all that it calls: then CasADi's null checks are decided at compile time
#define FLAT __attribute__((flatten, noinline))

// stands for the arguments that a front does not read
static const V NEVER = NAN;

template <int N> INLINE void copy(const V *from, V *to) {
#pragma GCC unroll 64  // gcc would call memmove instead
    for (int i = 0; i < N; ++i) to[i] = from[i];
}

// The front where the quick one may be wrong.
static __attribute__((noinline)) void look_again(const V *c, V doubt, Sight &sight) {
    V front[N_FRONT], nothing[Front::N_DOMAIN + 1];
    for (int i = 0; i < 4; ++i) {
        V *staged = sight.staged + i * N_STAGED, *own = staged + N_MEASURED;
        Front::out(&NEVER, c, 0, &NEVER, staged, front, nothing);
        for (int j = 0; j < N_FRONT; ++j) own[j] = select(doubt, front[j], own[j]);
    }
}

// What a front makes of the measurements.
template <class N>
static FLAT void see(const FrontPart &part, int64_t n, Sight *sights) {
    for (int64_t k = 0; k < n; ++k) {
        Sight &sight = sights[k];
        V near[4 * N_FRONT + 1], nothing[N::N_DOMAIN + 1], doubt = 1.0;
        if constexpr (HAS_NEAR) {
            N::out(&NEVER, part.c_near, 0, &NEVER, sight.staged, near, nothing);
            doubt = near[4 * N_FRONT];
            for (int i = 0; i < 4; ++i) copy<N_FRONT>(near + i * N_FRONT, sight.staged + i * N_STAGED + N_MEASURED);
        }
        if (any(doubt)) look_again(part.c, doubt, sight);
    }
}

// true in a lane where a state or an output may be beyond its limit, or the domain is left
template <class B> INLINE V suspect(const V *x, const V *y, const V *domain, const V *scales) {
    V doubt = !(B::magnitude(x, y, scales) <= 1.0);
    for (int i = 0; i < B::N_DOMAIN; ++i) doubt = !(V(0.0) < domain[i]) + doubt;
    return doubt;
}

// What fails first in a lane, counted over x, y, domain; −1 if nothing does.
template <class B> static int failing(const V *x, const V *y, const V *domain, const V *scales, int l) {
    for (int i = 0; i < B::NX + B::NY; ++i) {
        const double value = lane(i < B::NX ? x[i] : y[i - B::NX], l);
        if (!(fabs(value) * lane(scales[i], l) <= 1)) return i;
    }
    for (int i = 0; i < B::N_DOMAIN; ++i)
        if (!(lane(domain[i], l) > 0)) return B::NX + B::NY + i;
    return -1;
}

// Sizes as compiled, so that the caller can compare them with what it believes.
template <class B> static int64_t *sizes_of(int64_t *sizes) {
    const int64_t own[] = {B::NX, B::NP, B::NC, B::NY, B::N_GUARDS, B::N_DOMAIN};
    for (int64_t size : own) *sizes++ = size;
    return sizes;
}

static int64_t *sizes_of_all(List<>, int64_t *sizes) { return sizes; }

template <class B, class... Rest> static int64_t *sizes_of_all(List<B, Rest...>, int64_t *sizes) {
    return sizes_of_all(List<Rest...>(), sizes_of<B>(sizes));
}
