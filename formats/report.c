#include "report.h"

#include <stdarg.h>
#include <stdio.h>

void al_report_finding(al_report *report, enum al_rule rule, const char *format, ...)
{
    char message[AL_ERROR_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    report->count++;
    if (report->on_finding) report->on_finding(report->user, rule, message);
    if (report->status == AL_OK)
        report->status =
            al_fail(report->error, AL_BAD_INPUT, "%s: %s (rule %d)", report->name, message, (int)rule);
}

void al_report_out_of_memory(al_report *report)
{
    report->count++;
    if (report->status == AL_OK)
        report->status = al_fail(report->error, AL_IO, "%s: out of memory while reading", report->name);
}

bool al_report_data(al_report *report, const al_file *file, size_t index, const void **data, size_t *size)
{
    bool first = report->status == AL_OK; /* never so once al_file_check has found a wrong checksum */
    al_status status = al_file_data(file, index, data, size, first ? report->error : NULL);
    if (status != AL_OK) report->count++;
    if (status != AL_OK && first) report->status = status;
    return status == AL_OK;
}
