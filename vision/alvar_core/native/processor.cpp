// What the processor and this library can do, for native.py.

extern "C" int alvar_interface() { return ALVAR_INTERFACE; }

extern "C" int alvar_processor_has_avx2() {
#if defined(__x86_64__) && defined(__GNUC__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return 0;
#endif
}
