# Compares OURS.csv with TRUTH.csv row by row, by the columns after `skip`: r,g,b and their standard errors in both.
# Prints the mean of (A - B)^2 / (EA^2 + EB^2), the difference of all points together in standard errors and in
# percent, and the relative rms difference without noise. Exit 1 when chi2 is 2 or more, or all together differ by four
# standard errors and 0.5 %. With `order` given only the first of the three is compared, with TRUTH's column of that
# order (0: direct) and its error eight columns later. Usage: awk -F, -v skip=6 -f points.awk OURS.csv TRUTH.csv
/^[#x]/ { next }
FNR == NR { ours[++count] = $0; next }
{
    split(ours[++row], a, ",")
    channels = order == "" ? 3 : 1
    for (c = 1; c <= channels; c++) {
        value = a[skip + c]; error = a[skip + c + 3]
        at = order == "" ? skip + c : skip + 1 + order
        truth = $at; truth_error = $(order == "" ? at + 3 : at + 8)
        noise = error ^ 2 + truth_error ^ 2
        if (noise > 0) { chi2 += (value - truth) ^ 2 / noise; values++ }
        else if (value != truth) { print "row " row ": " value " is not " truth " though both are sure"; bad = 1 }
        difference += value - truth; sum += truth; sum2 += truth ^ 2; variance += noise
        square += (value - truth) ^ 2
        ours_error[row] += error; theirs_error[row] += truth_error
    }
    # one path carries the three channels: their noise adds up
    together += ours_error[row] ^ 2 + theirs_error[row] ^ 2
}
END {
    if (!values || row != count) { print count + 0 " rows against " row + 0; exit 1 }
    chi2 /= values
    sigmas = difference / sqrt(together); percent = 100 * difference / sum
    left = square > variance ? sqrt((square - variance) / sum2) : 0
    printf "chi2 %.2f, together %.2f sigma %.3f %%, rms without noise %.3f %%\n", chi2, sigmas, percent, 100 * left
    if (chi2 >= 2 || (sigmas ^ 2 >= 16 && percent ^ 2 >= 0.25) || bad) exit 1
}
