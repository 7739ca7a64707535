% The bar of examples/scenes/shaken-stop.toml by Octave: hat functions, a spring as the obstacle, ode15s in time. The
% spring is as stiff as FACTOR cells. Prints a CSV. Usage: octave octave_bar.m ELEMENTS FACTOR
1;
function f = reaction (t, u, k)
  f = k * max (0, -(u + 1e-4 - 1e-4 * (1 - cos (2 * pi * 400 * t))));
end
function r = rates (t, y, n, A, b, k, m)
  r = A * y + b;
  r(n+1) += reaction (t, y(1), k) / m;
end
arguments = argv ();
N = str2double (arguments{1});
E = 210e9; rho = 7850; eta = 2e5; h = 1 / N; n = N + 1;
k = str2double (arguments{2}) * E / h;
e = ones (n, 1);
D = spdiags ([e, -2 * e, e], -1:1, n, n) / h^2;   % half a cell belongs to an end
D(1,2) *= 2;
D(n,n-1) *= 2;
A = [sparse(n, n), speye(n); E / rho * D, eta / rho * D];
b = [zeros(n, 1); -77008.5 / rho * e];
m = rho * h / 2;
J = @(t, y) A - sparse (n + 1, 1, k / m * (reaction (t, y(1), k) > 0), 2 * n, 2 * n);
t = linspace (0, 0.02, 201);
options = odeset ("RelTol", 1e-6, "AbsTol", [1e-11 * e; 1e-7 * e], "Jacobian", J, "MaxStep", 1e-5);
[t, y] = ode15s (@(t, y) rates (t, y, n, A, b, k, m), t, [zeros(n, 1); -0.5 * e], options);
printf ("t,u_left,v_left,reaction_left,u_right,v_right\n");
for i = 1:numel (t)
  printf ("%.7g,%.7g,%.7g,%.7g,%.7g,%.7g\n", t(i), y(i,1), y(i,n+1), reaction (t(i), y(i,1), k), y(i,n), y(i,2*n));
end
