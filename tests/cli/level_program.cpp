#include <cstdio>

int main() { std::puts("x86-64"); }
