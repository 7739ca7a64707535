% The rebound B3 of docs/gallery.md as one would write it with Octave: hat functions, consistent mass, the contact
% released by an event of ode15s.
1;
function [value, terminal, direction] = reaction (y, b, h, n, minus)
  a = minus(1,:) * (y(1:n) + b * y(n+1:2*n));
  value = -(y(1) + b * y(n+1)) / h + h / 6 * a;
  terminal = 1;
  direction = -1;
end
for b = [1, 0.1]
  exact = [1.3692116746, 0.1503140958];
  if b == 0.1
    exact = [1.9124710098, 0.6507936369];
  end
  for n = [30, 120]
    h = 1 / n;
    e = ones (n, 1);
    M = spdiags ([e, 4 * e, e] * h / 6, -1:1, n, n);
    K = spdiags ([-e, 2 * e, -e] / h, -1:1, n, n);
    M(n,n) /= 2;
    K(n,n) /= 2;
    minus = -full (M \ K);
    A = sparse ([zeros(n), eye(n); minus, b * minus]);
    start = [zeros(n, 1); M \ (M * -e + [-h / 6; zeros(n - 1, 1)])];
    options = odeset ("RelTol", 1e-8, "AbsTol", 1e-11, "Jacobian", A, "InitialSlope", A * start, ...
                      "Events", @(t, y) reaction (y, b, h, n, minus));
    begun = cputime;
    [t, y, te, ye] = ode15s (@(t, y) A * y, [0, 2.5], start, options);
    seconds = cputime - begun;
    v = ye(end, n+1:2*n)';
    speed = sum (M * v) + h / 6 * v(1);
    printf ("Octave's ode15s, RelTol 1e-8, consistent mass, viscosity %g, %d elements: errors %.1e / %.1e, %.2g s\n", ...
            b, n, abs (te(end) - exact(1)), abs (speed - exact(2)), seconds);
  end
end
