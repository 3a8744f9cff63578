#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/measured.h"
#include "inspect.h"

json_t *json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *json_numbers(const float *values, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++) json_array_append_new(array, json_number(values[i]));
    return array;
}

json_t *json_text(const char *text)
{
    json_t *string = json_string(text);
    if (string) return string;
    char *copy = strdup(text);
    for (char *c = copy; c && *c; c++)
        if ((unsigned char)*c >= 0x80) *c = '?';
    string = json_string(copy ? copy : "");
    free(copy);
    return string;
}

json_t *json_provenance(const al_file *file)
{
    const void *data;
    size_t size;
    ptrdiff_t index = al_file_find(file, "PROV", 0);
    json_t *root = NULL;
    if (index >= 0 && al_file_data(file, (size_t)index, &data, &size, NULL) == AL_OK)
        root = json_loadb(data, size, 0, NULL);
    return root ? root : json_null();
}

json_t *json_measured(const al_file *file)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < al_measured_count(file); i++) {
        al_measured m;
        if (al_measured_read(file, i, &m, NULL) != AL_OK) continue;
        json_t *one = json_pack("{s:s,s:s,s:s,s:I}", "compared", m.compared, "settings", m.settings, "unit",
                                m.unit, "count", (json_int_t)m.count);
        json_object_set_new(one, "relative_rmse", json_number(m.rmse / m.truth_rms));
        json_object_set_new(one, "rmse", json_number(m.rmse));
        json_object_set_new(one, "truth_rms", json_number(m.truth_rms));
        json_object_set_new(one, "largest", json_number(m.largest));
        json_object_set_new(one, "standard_error", json_number(m.standard_error));
        json_array_append_new(list, one);
    }
    return list;
}

al_status query_vector(const json_t *query, const char *key, float vector[3], al_error *error)
{
    const json_t *array = json_object_get(query, key);
    bool good = json_array_size(array) == 3;
    for (size_t i = 0; i < 3 && good; i++) {
        const json_t *number = json_array_get(array, i);
        vector[i] = (float)json_number_value(number);
        good = json_is_number(number) && isfinite(vector[i]);
    }
    return good ? AL_OK
                : al_fail(error, AL_USAGE, "--eval: \"%s\" should be three finite numbers, such as [0, 1, 0]",
                          key);
}

al_status query_keys(const json_t *query, const char *const *keys, al_error *error)
{
    for (void *i = json_object_iter((json_t *)query); i; i = json_object_iter_next((json_t *)query, i)) {
        const char *const *known = keys;
        char list[256] = "";
        while (*known && strcmp(*known, json_object_iter_key(i))) known++;
        if (*known) continue;
        for (const char *const *key = keys; *key; key++) {
            size_t used = strlen(list);
            snprintf(list + used, sizeof list - used, "%s%s", key == keys ? "" : key[1] ? ", " : " and ", *key);
        }
        return al_fail(error, AL_USAGE, "--eval: unknown key \"%s\", this kind of asset takes %s",
                       json_object_iter_key(i), list);
    }
    return AL_OK;
}
