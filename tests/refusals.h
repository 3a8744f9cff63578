/* Refusals of a random test, counted by their words: those that differ in their numbers alone are one kind. */
#ifndef AIRLIGHT_TEST_REFUSALS_H
#define AIRLIGHT_TEST_REFUSALS_H

#include <stdio.h>
#include <string.h>

enum { REFUSAL_KIND_LIMIT = 64 };

static struct {
    char text[96];
    int count;
} refusal_kinds[REFUSAL_KIND_LIMIT];
static int refused, refusal_kind_count;

/* Of the first line. */
static inline void count_refusal(const char *message)
{
    char text[sizeof refusal_kinds[0].text];
    size_t size = 0;
    for (const char *c = message; *c && *c != '\n' && size + 1 < sizeof text; c++)
        if (*c < '0' || *c > '9') text[size++] = *c;
    text[size] = 0;
    int i = 0;
    while (i < refusal_kind_count && strcmp(refusal_kinds[i].text, text) != 0) i++;
    if (i == refusal_kind_count && i < REFUSAL_KIND_LIMIT) strcpy(refusal_kinds[refusal_kind_count++].text, text);
    if (i < refusal_kind_count) refusal_kinds[i].count++;
    refused++;
}

static inline void print_refusals(void)
{
    for (int i = 0; i < refusal_kind_count; i++) printf("%5d refused: %s\n", refusal_kinds[i].count, refusal_kinds[i].text);
}

#endif
